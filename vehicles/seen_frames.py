"""Recognises repeated frames in real time, where nothing else tells that a frame is repeated."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from typing import Final

_REMEMBERED_NS: Final = 5_000_000_000  # a frame that is older than the newest by more is stale
_SPAN_NS: Final = 100_000_000
_NONE: Final = frozenset[Hashable]()


class SeenFrames:
    """The frames of the last seconds, each known by what tells it from others, and its arrival.

    Their contents do not matter: otherwise a frame with one changed bit would count as new.
    """

    def __init__(self) -> None:
        # By span of arrival. A single set of half a million frames, which Python rebuilds now and
        # then as old ones leave it, held up 500 vehicles for 40 ms every few seconds.
        self._known: dict[int, set[Hashable]] = {}
        self._newest_ns = 0

    def are_new(self, frames: Sequence[Hashable], arrived_ns: Sequence[int]) -> bool:
        """Return whether there are frames, and all are new; if so, remember them."""
        if not frames or min(arrived_ns) <= self._newest_ns - _REMEMBERED_NS:
            return False
        by_span = _by_span(frames, arrived_ns)
        known = self._known
        if not all(known.get(span, _NONE).isdisjoint(those) for span, those in by_span.items()):
            return False
        for span, those in by_span.items():
            known.setdefault(span, set()).update(those)
        self._newest_ns = max(self._newest_ns, *arrived_ns)
        self._forget((self._newest_ns - _REMEMBERED_NS) // _SPAN_NS)
        return True

    def _forget(self, span: int) -> None:
        """Drop the frames of all spans before this one."""
        for old in [one for one in self._known if one < span]:
            del self._known[old]


def _by_span(
    frames: Sequence[Hashable], arrived_ns: Sequence[int]
) -> Mapping[int, Sequence[Hashable]]:
    """Return the frames by span of arrival; nearly always, it is one span."""
    first = min(arrived_ns) // _SPAN_NS
    if max(arrived_ns) // _SPAN_NS == first:
        return {first: frames}
    found: defaultdict[int, list[Hashable]] = defaultdict(list)
    for frame, at_ns in zip(frames, arrived_ns, strict=True):
        found[at_ns // _SPAN_NS].append(frame)
    return found
