"""The errors of laws: when a law cannot be found, and when it fails."""

from __future__ import annotations

import inspect
import signal
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Final

_LONGEST: Final = 100  # characters of a value in a message


class UnknownLawError(Exception):
    """A reference does not lead to a law; the text says why."""


class LawError(Exception):
    """A law raised, or returned something that is not an acceleration.

    The text names the law, and the line in its file. `process` is the name of the vehicle's
    process, once it is known.
    """

    process: str = ""


def raised(name: str, code: object, error: BaseException) -> LawError:
    """Return the error for an exception that a law raised: its kind, and the line of the law.

    `name` describes the code, such as "law Smith"; `code` is its function or class.
    """
    file, line = deepest(error.__traceback__, {_file(code)})
    place = f" ({Path(file).name}, line {line})" if line else _place(code)
    return LawError(f"{name} raised {described(error)}{place}")


def useless(name: str, code: object, what: str) -> LawError:
    """Return the error for a law whose result cannot be used, with the line of the law."""
    return LawError(f"{name} {what}{_place(code)}")


def described(error: BaseException) -> str:
    """Return the kind of an error and its text in a line, without the place of a SyntaxError."""
    text = f"{type(error).__name__}: {getattr(error, 'msg', None) or error}".rstrip(": ")
    return " ".join(text.split())


def shortened(value: object) -> str:
    """Return a value as a line that is not too long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def deepest(trace: TracebackType | None, files: Collection[str]) -> tuple[str, int]:
    """Return the innermost file and line in one of the files, and not in a library that they call.

    It is ("", 0) if the traceback passes through none of them.
    """
    found = ("", 0)
    while trace is not None:
        if trace.tb_frame.f_code.co_filename in files:
            found = (trace.tb_frame.f_code.co_filename, trace.tb_lineno)
        trace = trace.tb_next
    return found


@contextmanager
def errors_of_the_code(wrapped: Callable[[BaseException], Exception]) -> Iterator[None]:
    """Raise `wrapped(error)` for any exception of a user's code, including that of `sys.exit`.

    An exception from a signal, such as KeyboardInterrupt, does not come from the code, and passes.
    """
    asked = False

    def noting(handler: Callable[[int, FrameType | None], Any]) -> Any:
        def note(number: int, frame: FrameType | None) -> Any:
            nonlocal asked
            asked = True
            return handler(number, frame)

        return note

    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            handler = signal.getsignal(number)
            if callable(handler):  # it may raise while the code runs
                before[number] = handler
                signal.signal(number, noting(handler))
    try:
        yield
    except BaseException as error:
        if asked:
            raise
        raise wrapped(error) from error
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _place(code: object) -> str:
    """Return where a function or class is defined, in parentheses; "" if that is not known."""
    file = Path(_file(code)).name
    line = getattr(getattr(code, "__code__", None), "co_firstlineno", None)
    if line is not None:
        return f" ({file}, line {line})"
    return f" ({file})" if file else ""


def _file(code: Any) -> str:
    try:
        return inspect.getfile(code)
    except (TypeError, OSError):  # built-in code has no file
        return ""
