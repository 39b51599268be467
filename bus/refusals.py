"""What was refused: counted by reason, and reported once for each reason and source."""

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
_MOST_REPORTED: Final = 20
_LONGEST_SOURCE: Final = 100


class RefusedError(Exception):
    """A message is refused, for one of the reasons above."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Refusals:
    """Refused messages of one process; what it reports goes to its log, by way of stderr."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._reported: set[tuple[str, str]] = set()
        self.counts: Counter[str] = Counter()
        self.total = 0

    def add(self, reason: str, source: str) -> None:
        """Count one; `source` is the key that it came on."""
        self.counts[reason] += 1
        self.total += 1
        reported = self._reported
        if len(reported) > _MOST_REPORTED:
            return
        kind = reason, ascii(source[:_LONGEST_SOURCE])  # a key may hold anything, also line ends
        if kind in reported:
            return
        reported.add(kind)
        if len(reported) > _MOST_REPORTED:
            self._report(
                "messages of more kinds or sources are refused, and from now on only counted"
            )
        else:
            self._report(f"refused: {reason}, on {kind[1]}")

    def report_counts(self) -> None:
        """Say how many there were, where there were any."""
        if self.counts:
            counts = ", ".join(f"{count} {why}" for why, count in sorted(self.counts.items()))
            self._report(f"messages refused: {counts}")

    def _report(self, text: str) -> None:
        print(f"{self._name}: {text}", file=sys.stderr, flush=True)
