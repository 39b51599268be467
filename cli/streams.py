"""Standard output and standard error that no command can fall over.

What a stream cannot show is replaced by what it can. A write that fails is kept in mind and told at
the end: the work goes on, and its files are there, whoever has stopped to listen.
"""

from __future__ import annotations

import codecs
import errno
import io
import os
import select
import sys
from typing import TYPE_CHECKING, Final, TextIO

from zenvoy.cli import exits

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_REPLACED: Final = "zenvoy.replaced"
# Signs of our own, for terminals that have none of them. All others are told by their number.
_SIGNS: Final = str.maketrans(
    {
        "×": "x", "·": "*", "−": "-", "–": "-", "⁻": "-", "±": "+/-", "√": "sqrt", "≥": ">=",
        "≤": "<=", "∞": "inf", "…": "...", "→": "->", "µ": "u", "¹": "1", "²": "2", "³": "3",
        "⁴": "4", "⁵": "5", "ᵀ": "^T", "₁": "1", "₂": "2",
        "α": "alpha", "β": "beta", "θ": "theta", "κ": "kappa", "λ": "lambda", "π": "pi",
        "ρ": "rho", "σ": "sigma", "τ": "tau", "χ": "chi", "ω": "omega",
        "Δ": "Delta", "Σ": "Sum", "Φ": "Phi",
    }
)  # fmt: skip


class Outlet(io.FileIO):
    """A file descriptor that is written to; the first `failure` is kept, and none is raised."""

    def __init__(self, number: int) -> None:
        super().__init__(number, "wb", closefd=False)
        self.failure: OSError | None = None

    def write(self, data: ReadableBuffer, /) -> int:
        """Write what can be written; all of `data` counts as written where nothing can."""
        size = memoryview(data).nbytes
        try:
            while (written := super().write(data)) is None:  # shared with one who does not block
                select.select([], [self], [])
        except OSError as error:
            self.failure = self.failure or error
            return size
        return written


def fill_closed() -> None:
    """Open what stands for standard streams that are closed: else the next file is taken for one.

    Each of them fails as a closed one does, for it is open for the other direction alone.
    """
    for number, way in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_RDONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, way)  # the lowest number that is free: this one
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  # whoever reads stdin expects it open


def install() -> None:
    """Put streams over outlets in place of `sys.stdout` and `sys.stderr`."""
    codecs.register_error(_REPLACED, _replaced)
    sys.stdout = _stream(1, sys.stdout)
    sys.stderr = _stream(2, sys.stderr)


def settle(code: int) -> int:
    """Write out what is left to write; `code`, or 1 where all went well but this.

    A pipe that its reader has closed is no failure: the reader has had enough.
    """
    failure = _failure(sys.stdout)
    if failure is not None:
        print(f"standard output cannot be written to: {failure.strerror}", file=sys.stderr)
    if failure is None:
        failure = _failure(sys.stderr)
    else:
        sys.stderr.flush()
    return exits.FAILED if failure is not None and code == 0 else code


def _stream(number: int, stream: TextIO | None) -> io.TextIOWrapper:
    outlet = Outlet(number)
    errors = getattr(stream, "errors", None)
    return io.TextIOWrapper(
        io.BufferedWriter(outlet),
        encoding=getattr(stream, "encoding", None) or "utf-8",
        # Python's own choices; whoever asks for another one in PYTHONIOENCODING has it.
        errors=_REPLACED if errors in _PYTHONS else errors,
        line_buffering=number == 2 or outlet.isatty(),
    )


_PYTHONS: Final = frozenset({None, "strict", "surrogateescape", "backslashreplace"})


def _failure(stream: TextIO) -> OSError | None:
    stream.flush()
    outlet = getattr(getattr(stream, "buffer", None), "raw", None)
    failure = outlet.failure if isinstance(outlet, Outlet) else None
    return None if failure is None or failure.errno == errno.EPIPE else failure


def _replaced(error: UnicodeError) -> tuple[str | bytes, int]:
    """What stands for characters that an encoding has not: signs in ASCII, or their number."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(_SIGNS)
    return text.encode("ascii", "backslashreplace").decode("ascii"), error.end
