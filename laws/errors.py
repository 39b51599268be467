"""What can go wrong with a law while it runs."""

from __future__ import annotations

import inspect
from pathlib import Path
from types import TracebackType
from typing import Any


class LawError(Exception):
    """A law raised, or returned what is no acceleration; says which law, and where in its file.

    `process` is the name of the vehicle's process, once it is known.
    """

    process: str = ""


def raised(name: str, code: object, error: Exception) -> LawError:
    """Return what to say of an error that came out of a law: its kind, and the law's own line.

    `name` says what the code is, such as "law IDM"; `code` is its function or class.
    """
    said = f"{type(error).__name__}: {error}".rstrip(": ")
    return LawError(f"{name} raised {said}{_deepest(error.__traceback__, _file(code))}")


def useless(name: str, code: object, what: str) -> LawError:
    """Return what to say of a law that returns what is of no use, with the place of the law."""
    first = getattr(getattr(code, "__code__", None), "co_firstlineno", None)
    place = f" ({Path(_file(code)).name}, line {first})" if first is not None else ""
    return LawError(f"{name} {what}{place}")


def _file(code: Any) -> str:
    try:
        return inspect.getfile(code)
    except (TypeError, OSError):  # it is of no file, such as what is built in
        return ""


def _deepest(trace: TracebackType | None, file: str) -> str:
    """The innermost line in the law's own file, and not in a library that it calls."""
    lines = []
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    return f" ({Path(file).name}, line {lines[-1]})" if lines else ""
