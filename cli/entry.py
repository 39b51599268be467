"""Where the `zenvoy` command starts: what must stand before anything heavy is imported.

The commands import numpy, matplotlib and Zenoh, which takes a second. A request to end must not
find Python's own handlers meanwhile, and a stream that is closed must not become somebody's file.
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
    """Entry point of the console script."""
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
    code = streams.settle(code)
    for number in REQUESTS_TO_END:  # too late: the interpreter tidies up, without its handlers
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
    """End at once, and without a word, as long as there is nothing to tidy up."""
    for number in REQUESTS_TO_END:
        if signal.getsignal(number) is not signal.SIG_IGN:  # nohup's, or a shell's for its jobs
            signal.signal(number, _leave)


def _leave(_signal: int, _frame: FrameType | None) -> None:
    os._exit(exits.INTERRUPTED)


def _speak_utf8() -> None:
    """Begin anew where Python takes names of files for something else than UTF-8.

    In the locale C, say, with UTF-8 mode turned off. What the terminal shows stays as it is.
    """
    if sys.getfilesystemencoding() == "utf-8":
        return
    import locale

    os.environ.setdefault("PYTHONIOENCODING", locale.getencoding())
    program, *arguments = sys.orig_argv
    os.execv(sys.executable, [program, "-X", "utf8", *arguments])
