"""What was refused: counted by reason, and told once for each reason and source."""

from __future__ import annotations

import sys
from collections import Counter
from typing import Final

MALFORMED: Final = "malformed"  # not a message of its topic, or columns that do not go together
FOREIGN: Final = "foreign"  # on the key of nobody here, or of another vehicle than its key's
STALE: Final = "stale"  # of a cycle that is over
EARLY: Final = "early"  # of a cycle that cannot have begun
DUPLICATE: Final = "duplicate"  # the first one counts
MISTIMED: Final = "mistimed"  # of another time than its cycle's
ABSURD: Final = "absurd"  # numbers that nothing can come of
OVERFLOW: Final = "overflow"  # in real time: more than the process can read

# Whoever sends rubbish must not fill the disk with what is said of it.
_MOST_TOLD: Final = 20
_LONGEST_SOURCE: Final = 100


class RefusedError(Exception):
    """A message is refused, for one of the reasons above."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Refusals:
    """Refused messages of one process; what is told goes to its log, by way of stderr."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._told: set[tuple[str, str]] = set()
        self.counts: Counter[str] = Counter()
        self.total = 0

    def add(self, reason: str, source: str) -> None:
        """Count one; `source` is the key that it came on."""
        self.counts[reason] += 1
        self.total += 1
        told = self._told
        if len(told) > _MOST_TOLD:
            return
        kind = reason, ascii(source[:_LONGEST_SOURCE])  # a key may hold anything, also line ends
        if kind in told:
            return
        told.add(kind)
        if len(told) > _MOST_TOLD:
            self._tell(
                "messages of more kinds or sources are refused, and from now on only counted"
            )
        else:
            self._tell(f"refused: {reason}, on {kind[1]}")

    def tell_counts(self) -> None:
        """Say how many there were, where there were any."""
        if self.counts:
            counts = ", ".join(f"{count} {why}" for why, count in sorted(self.counts.items()))
            self._tell(f"messages refused: {counts}")

    def _tell(self, text: str) -> None:
        print(f"{self._name}: {text}", file=sys.stderr, flush=True)
