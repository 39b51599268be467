"""What can go wrong with a law while it runs."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType


class LawError(Exception):
    """A law raised, or returned what is no acceleration; says which law, and where in its file."""


def raised(name: str, error: Exception) -> LawError:
    """Return what to say of an error that came out of a law: the last line of the law's own."""
    where = _deepest(error.__traceback__)
    said = f"{type(error).__name__}: {error}".rstrip(": ")
    return LawError(f"law {name} raised {said}{where}")


def _deepest(trace: TracebackType | None) -> str:
    """The innermost line in the file that the law was called in: its own, not a library's."""
    frames = []
    while trace is not None:
        frames.append((trace.tb_frame.f_code.co_filename, trace.tb_lineno))
        trace = trace.tb_next
    own = [frame for frame in frames[1:] if frame[0] == frames[1][0]]
    return f" ({Path(own[-1][0]).name}, line {own[-1][1]})" if own else ""
