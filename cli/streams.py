"""Standard output and standard error that never raise.

Characters that a stream cannot encode are replaced. A write that fails is remembered and reported
at the end, so that the work goes on and its files are written even if nobody reads the output.
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

REPLACED: Final = "zenvoy.replaced"
# ASCII for the signs that Zenvoy prints. Other characters become escapes such as \u20ac.
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
    """A file descriptor to write to; it keeps the first `failure`, and raises none."""

    def __init__(self, number: int) -> None:
        super().__init__(number, "wb", closefd=False)
        self.failure: OSError | None = None

    def write(self, data: ReadableBuffer, /) -> int:
        """Write `data` and return the number of bytes; after a failure, pretend to have written."""
        size = memoryview(data).nbytes
        try:
            while (written := super().write(data)) is None:  # another process made it non-blocking
                select.select([], [self], [])
        except OSError as error:
            self.failure = self.failure or error
            return size
        return written


def fill_closed() -> None:
    """Open a placeholder for each closed standard stream, so that no file gets its descriptor.

    A placeholder is open in the opposite direction, so that using it fails as on a closed stream.
    """
    for number, mode in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_RDONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # this takes the lowest free number, which is `number`
    if sys.stdin is None:
        sys.stdin = os.fdopen(0, encoding="utf-8", closefd=False)


def install() -> None:
    """Replace `sys.stdout` and `sys.stderr` by streams that write to an Outlet."""
    codecs.register_error(REPLACED, _replaced)
    sys.stdout = _stream(1, sys.stdout)
    sys.stderr = _stream(2, sys.stderr)


def flush(code: int) -> int:
    """Flush both streams; return `code`, or 1 if it is 0 and the output could not be written.

    A pipe that its reader has closed (`| head`) is no failure.
    """
    failure = _failure(sys.stdout)
    if failure is not None:
        print(f"cannot write to standard output: {failure.strerror}", file=sys.stderr)
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
        # Replace Python's defaults only; a choice made by PYTHONIOENCODING stays.
        errors=REPLACED if errors in _PYTHON_DEFAULTS else errors,
        line_buffering=number == 2 or outlet.isatty(),
    )


_PYTHON_DEFAULTS: Final = frozenset({None, "strict", "surrogateescape", "backslashreplace"})


def _failure(stream: TextIO) -> OSError | None:
    stream.flush()
    outlet = getattr(getattr(stream, "buffer", None), "raw", None)
    failure = outlet.failure if isinstance(outlet, Outlet) else None
    return None if failure is None or failure.errno == errno.EPIPE else failure


def _replaced(error: UnicodeError) -> tuple[str | bytes, int]:
    """Replace characters that the encoding lacks: by ASCII signs, or by their escapes."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(_SIGNS)
    return text.encode("ascii", "backslashreplace").decode("ascii"), error.end
