"""The entry point of the `zenvoy` command: everything that comes before the slow imports.

The commands import numpy, matplotlib and Zenoh, which takes a second. In the meantime a signal must
not reach Python's default handlers, and no file must get the descriptor of a closed stream.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

from zenvoy.cli import exits
from zenvoy.fleet.requests import REQUESTS_TO_END


def main() -> NoReturn:
    """Run the command line and exit."""
    _leave_on_request()
    _speak_utf8()
    from zenvoy.cli import streams

    streams.fill_closed()
    streams.install()
    _require_memory()
    from zenvoy.cli.app import app
    from zenvoy.cli.usage import outcome

    code = outcome(app)
    _leave_on_request()
    code = streams.flush(code)
    for number in REQUESTS_TO_END:  # the interpreter shuts down, and its handlers are gone
        signal.signal(number, signal.SIG_IGN)
    sys.exit(code)


def _require_memory() -> None:
    from zenvoy.fleet.limits import LimitError, require_memory

    try:
        require_memory()
    except LimitError as error:
        print(error, file=sys.stderr, flush=True)
        os._exit(exits.FAILED)


def _leave_on_request() -> None:
    """Exit at once and in silence on a signal, while there is nothing to clean up."""
    for number in REQUESTS_TO_END:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup, or as a shell's job
            signal.signal(number, _leave)


def _leave(_signal: int, _frame: FrameType | None) -> None:
    os._exit(exits.INTERRUPTED)


def _speak_utf8() -> None:
    """Restart Python in UTF-8 mode where file names are not UTF-8.

    This happens in the locale C with UTF-8 mode turned off. The encoding of the terminal is kept.
    """
    if sys.getfilesystemencoding() == "utf-8":
        return
    import locale

    os.environ.setdefault("PYTHONIOENCODING", locale.getencoding())
    program, *arguments = sys.orig_argv
    os.execv(sys.executable, [program, "-X", "utf8", *arguments])
