"""A run as the page sees it: its log, read as far as it goes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from zenvoy.analysis.log.cycles import stretches
from zenvoy.analysis.log.event_words import event_words
from zenvoy.analysis.log.facts import printable
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.about import about
from zenvoy.analysis.view.block import pack
from zenvoy.analysis.view.growing_log import GrowingLog, still_limit_s
from zenvoy.analysis.view.messages import Messages, Payloads
from zenvoy.analysis.view.overview import Overview
from zenvoy.analysis.view.picture import COLUMNS, Picture, picture_of, rows_of
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import RESULT, RUN, read_epoch_ns
from zenvoy.scenarios import Scenario

MAX_CYCLES: Final = 4_096
"""The most cycles that one request gets."""
_CHUNKS_AT_ONCE: Final = 8
_POINTS_AT_ONCE: Final = 20
_FRAMES_AT_ONCE: Final = 100_000  # about, so that a request does not wait for long
_LOOKS_BACK: Final = 100  # cycles, for the last decisions
_MODE: Final = list(COLUMNS).index("mode")
_KEPT_NUMBERS: Final = 16_000_000  # in pictures, of 4 bytes each


class WatchedRun:
    """A run that may still go on. One thread at a time may use it."""

    def __init__(self, path: Path) -> None:
        self._log = GrowingLog(path)
        self._scenario: Scenario | None = None
        self._messages: Messages
        self._overview: Overview
        self._events: list[dict[str, Any]] = []
        self._searched = 0  # chunks searched for events
        self._faults: list[str] = []
        self._epoch_ns = self._behind_ns = 0
        self._kept: dict[int, Picture] = {}  # in the order in which they were made
        self._decided: Picture | None = None
        self._seen = -1  # the cycle up to which `_decided` is looked for

    def extend(self) -> bool:
        """Read what the run has logged since the last call, a part at a time.

        Returns whether there was anything; call again at once if so. Raises LogError for a file
        that is not the log of a run.
        """
        more = self._log.extend()
        if self._scenario is None:
            if not self._log.begun:
                return more
            self._begin(self._log.effective or b"")
        return self._search() or self._sample() or more

    def first_look(self) -> None:
        """Read what there is, before anybody looks.

        Raises LogError for a file that is not the log of a run, or that is cut before its run
        begins and does not grow.
        """
        self._log.first_look()
        self.extend()

    @property
    def begun(self) -> bool:
        """Whether the log says which run it is."""
        return self._scenario is not None

    @property
    def whole(self) -> bool:
        """Whether the log has its end, and all of it has been read."""
        searched = self._searched == len(self._log.chunks)
        return self._log.whole and searched and self._overview.due > self.last

    @property
    def last(self) -> int:
        """The last cycle of which all messages are there; -1 without any."""
        if self._scenario is None or not self._log.chunks:
            return -1
        newest_ns = max(place.last_ns for place in self._log.chunks[-4:]) - self._epoch_ns
        if not self._log.whole:
            newest_ns -= self._behind_ns
        return min(newest_ns // self._scenario.period_ns, self._scenario.cycles)

    def about(self) -> dict[str, Any]:
        """Return what does not change during the run."""
        return about(self._log.metadata, self._known)

    def state(self, events_from: int) -> dict[str, Any]:
        """Return how far the run is, and its events from a number on."""
        result = self._log.metadata.get(RESULT, {})
        return {
            "begun": self.begun,
            "last": self.last,
            "points": len(self._overview) if self.begun else 0,
            "end": printable(result["end"]) if "end" in result else None,
            "whole": self.begun and self.whole,
            "still": self._is_still,
            "events": self._events[events_from:],
            "faults": self._faults,
        }

    def cycles(self, first: int, last: int, step: int, vehicles: Sequence[int]) -> bytes:
        """Return the cycles in a range, one in `step`, of some vehicles or of all for none."""
        last = min(last, self.last, first + MAX_CYCLES * step)
        wanted = range(first + -first % step, last + 1, step)
        found = list(self._pictures(wanted).items())
        size = self._known.fleet.size
        take = np.array(vehicles, np.int64) - 1 if vehicles else np.arange(size)
        take = take[(take >= 0) & (take < size)]
        return pack(
            cycle=np.array([cycle for cycle, _ in found], np.uint32),
            vehicle=(take + 1).astype(np.uint32),
            position=np.array([p.position[take] for _, p in found], np.float64),
            columns=np.array([p.columns[:, take] for _, p in found], np.float32),
            totals=np.array([p.totals for _, p in found], np.float32),
        )

    def links(self, first: int, last: int, who: Collection[int]) -> bytes:
        """Return the frames of these cycles that vehicles send or receive; see `rows_of`."""
        last = min(last, self.last, first + MAX_CYCLES)
        ring = self._known.fleet.size if self._known.road.type == "ring" else 0
        return pack(**rows_of(self._messages.of(first, last), who, ring=ring)._asdict())

    def overview(self, first: int) -> bytes:
        """Return the points of the overview from a number on."""
        return pack(**self._overview.since(first))

    def decided(self) -> Picture | None:
        """Return the last cycle in which vehicles decide; None without any.

        At the end of a run it is not the last one: the world has moved on.
        """
        last = self.last
        for cycle in range(last, max(self._seen, last - _LOOKS_BACK), -1):
            picture = None
            with suppress(LogError):  # `_search` has reported it
                picture = self._pictures(range(cycle, cycle + 1)).get(cycle)
            if picture is not None and (picture.columns[_MODE] > 0).any():
                self._decided = picture
                break
        self._seen = max(last, self._seen)
        return self._decided

    def samples(self) -> dict[str, NDArray[np.generic]]:
        """Return all points of the overview."""
        return self._overview.since(0)

    @property
    def _is_still(self) -> bool:
        known = self._scenario
        return known is not None and self._log.is_still(still_limit_s(known))

    @property
    def _known(self) -> Scenario:
        if self._scenario is None:
            raise LogError(f"{self._log.path}: the run has not begun")
        return self._scenario

    def _begin(self, effective: bytes) -> None:
        try:
            scenario = Scenario.model_validate_json(effective)
        except ValidationError as error:
            raise LogError(f"{self._log.path}: its scenario is not valid") from error
        realtime = scenario.clock == "realtime"
        self._behind_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
        self._behind_ns += scenario.period_ns * (2 if realtime else 1)
        self._epoch_ns = read_epoch_ns(self._log.metadata[RUN])
        self._messages = Messages(self._log, self._epoch_ns, scenario.period_ns, self._behind_ns)
        self._overview = Overview(scenario.cycles, scenario.fleet.size)
        self._scenario = scenario

    def _pictures(self, cycles: range) -> dict[int, Picture]:
        """Return the pictures of the cycles that the log has, and keep them for the next time."""
        missing = [cycle for cycle in cycles if cycle not in self._kept]
        for first, last in stretches(missing):
            for cycle, payloads in self._messages.of(first, last).items():
                self._keep(cycle, payloads)
        found = {cycle: self._kept[cycle] for cycle in cycles if cycle in self._kept}
        most = max(2, _KEPT_NUMBERS // (self._known.fleet.size * (len(COLUMNS) + 2)))
        for cycle in list(islice(self._kept, max(0, len(self._kept) - most))):
            del self._kept[cycle]
        return found

    def _keep(self, cycle: int, payloads: Payloads) -> None:
        scenario = self._known
        picture = picture_of(payloads, scenario.fleet.size, scenario.ring_length_m)
        if picture is not None and cycle <= self.last:
            self._kept[cycle] = picture

    def _search(self) -> bool:
        """Find events in the next chunks; return whether there were any chunks."""
        new = self._log.chunks[self._searched : self._searched + _CHUNKS_AT_ONCE]
        for place in new:
            self._searched += 1
            try:
                events = self._messages.chunk(place).events
            except LogError as error:
                self._faults.append(str(error))
                continue
            self._events.extend(_event(event) for event in events)
        return bool(new)

    def _sample(self) -> bool:
        """Add the next points to the overview; return whether there were any."""
        before = len(self._overview)
        # Up to a size of 80 every vehicle may hear every other one; beyond, not all are in range.
        frames = self._known.fleet.size * min(self._known.fleet.size, 80)
        until = before + min(_POINTS_AT_ONCE, 1 + _FRAMES_AT_ONCE // frames)
        while self._overview.due <= self.last and len(self._overview) < until:
            cycle, pictures = self._overview.due, {}
            with suppress(LogError):  # `_search` has reported it
                pictures = self._pictures(range(cycle, cycle + 1))
            self._overview.add(pictures.get(cycle))
        return len(self._overview) > before


def _event(event: pb.Event) -> dict[str, Any]:
    """Return an event as values that JSON has."""
    known = event.kind in pb.EventKind.values()
    return {
        "time": event.time_ns * 1e-9,
        "kind": pb.EventKind.Name(event.kind).removeprefix("EVENT_") if known else "UNKNOWN",
        "vehicle": event.vehicle,
        "text": printable(event.text),
        "words": printable(event_words(event)),
    }
