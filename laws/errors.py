"""What can go wrong with a law while it runs."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from zenvoy.laws.law import Law


class LawError(Exception):
    """A law raised, or returned what is no acceleration; says which law, and where in its file.

    `process` is the name of the vehicle's process, once it is known.
    """

    process: str = ""


def raised(law: Law, error: Exception) -> LawError:
    """Return what to say of an error that came out of a law: its kind, and the law's own line."""
    said = f"{type(error).__name__}: {error}".rstrip(": ")
    return LawError(f"law {law.name} raised {said}{_deepest(error.__traceback__, law)}")


def useless(law: Law, what: str) -> LawError:
    """Return what to say of a law that returns what is of no use, with the place of the law."""
    code = getattr(law.acceleration, "__code__", None)
    place = f" ({Path(code.co_filename).name}, line {code.co_firstlineno})" if code else ""
    return LawError(f"law {law.name} {what}{place}")


def _deepest(trace: TracebackType | None, law: Law) -> str:
    """The innermost line in the law's own file, and not in a library that it calls."""
    code = getattr(law.acceleration, "__code__", None)
    lines = []
    while trace is not None:
        if code is not None and trace.tb_frame.f_code.co_filename == code.co_filename:
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    return f" ({Path(code.co_filename).name}, line {lines[-1]})" if code and lines else ""
