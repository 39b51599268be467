"""Exit codes of the `zenvoy` command, as the README lists them."""

from __future__ import annotations

from typing import Final

OK: Final = 0
FAILED: Final = 1
"""The work could not be done, or a check failed."""
BAD_INPUT: Final = 2
PROCESS_LOST: Final = 3
"""A process of the run died or stalled."""
INTERRUPTED: Final = 130
