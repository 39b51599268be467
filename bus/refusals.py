"""Refused messages: counted by reason, and reported once for each reason and source."""

from __future__ import annotations

import sys
from collections import Counter
from typing import Final

MALFORMED: Final = "malformed"  # not a message of its topic, or its columns do not match
FOREIGN: Final = "foreign"  # the key belongs to nobody here, or to another vehicle
STALE: Final = "stale"  # its cycle is over
EARLY: Final = "early"  # its cycle cannot have begun
DUPLICATE: Final = "duplicate"  # the first one counts
MISTIMED: Final = "mistimed"  # its time is not that of its cycle
ABSURD: Final = "absurd"  # its numbers make no sense, such as NaN or an unknown mode
UNCLOCKED: Final = "unclocked"  # in real time: its machine knows the world's clock too badly
OVERFLOW: Final = "overflow"  # in real time: more messages than the process can read

# Reports about a program that sends rubbish must not fill the disk.
_MOST_REPORTED: Final = 20
_LONGEST_SOURCE: Final = 100


class RefusedError(Exception):
    """A message is refused, for one of the reasons above."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Refusals:
    """The refused messages of one process. Reports go to stderr, and so to the process's log."""

    def __init__(self, name: str, most: int = _MOST_REPORTED) -> None:
        self._name = name
        self._most = most
        self._reported: set[tuple[str, str]] = set()
        self.counts: Counter[str] = Counter()
        self.total = 0

    def add(self, reason: str, source: str, count: int = 1) -> None:
        """Count refused messages; source: the key on which they arrived."""
        self.counts[reason] += count
        self.total += count
        reported = self._reported
        if len(reported) > self._most:
            return
        kind = reason, ascii(source[:_LONGEST_SOURCE])  # a key may contain anything, even line ends
        if kind in reported:
            return
        reported.add(kind)
        if len(reported) > self._most:
            self._report(
                "messages of more kinds or sources are refused, and from now on only counted"
            )
        else:
            self._report(f"refused: {reason}, on {kind[1]}")

    def report_counts(self) -> None:
        """Report the number of refused messages by reason, if there are any."""
        if self.counts:
            counts = ", ".join(f"{count} {why}" for why, count in sorted(self.counts.items()))
            self._report(f"messages refused: {counts}")

    def _report(self, text: str) -> None:
        print(f"{self._name}: {text}", file=sys.stderr, flush=True)
