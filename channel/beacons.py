"""Reads the beacons of a shared process together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.flat_reading import FlatReader
from zenvoy.channel.sent import Sent

_HUGE: Final = 1e300  # beyond this, `checks.is_sane` decides, which adds numbers


class Beacons(NamedTuple):
    """The beacons of some vehicles in a cycle that starts at `time_ns`, by vehicle."""

    cycle: int
    time_ns: int
    sent: Mapping[int, Sent]


class BeaconReader:
    """Reads beacons of cycles of this length."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._reader: Final = FlatReader(pb.Beacon.DESCRIPTOR)

    def together(self, parcels: Sequence[Parcel]) -> Beacons | None:
        """Return the beacons of some vehicles; None if any is in doubt, or their cycles differ.

        What is in doubt is up to `checks.fault_in_beacon`, which says what is wrong.
        """
        alike = self._reader.read([payload for _, payload in parcels])
        if alike is None:
            return None
        vehicles = np.array([vehicle for vehicle, _ in parcels])
        cycle = int(alike[0].fields["cycle"][0]) if "cycle" in _names(alike[0].fields) else 0
        time_ns, sent = cycle * self._period_ns, dict[int, Sent]()
        for at, fields in alike:
            heads = {name: _column(fields, name) for name in ("cycle", "time_ns", "sequence")}
            silent = _column(fields, "silent") != 0
            if not (
                (_column(fields, "vehicle") == vehicles[at]).all()
                and (heads["cycle"] == cycle).all()
                and (heads["time_ns"] == time_ns).all()
                and (heads["sequence"] <= cycle).all()
                and _has_a_plan_unless_silent(fields, silent)
                and _are_finite(fields)
            ):
                return None
            rows = zip(at.tolist(), heads["sequence"].tolist(), silent.tolist(), strict=True)
            for place, sequence, is_silent in rows:
                vehicle, payload = parcels[place]
                sent[vehicle] = Sent(cycle, time_ns, sequence, is_silent, payload)
        return Beacons(cycle, time_ns, sent)


def _names(fields: NDArray[Any]) -> Sequence[str]:
    return fields.dtype.names or ()


def _column(fields: NDArray[Any], name: str) -> NDArray[Any]:
    """Return a field of messages of one form, as numbers of 64 bits; 0 if they leave it out."""
    there = name in _names(fields)
    return fields[name].astype(np.int64) if there else np.zeros(len(fields), dtype=np.int64)


def _has_a_plan_unless_silent(fields: NDArray[Any], silent: NDArray[np.bool_]) -> bool:
    columns = [
        name for name in ("planned_from_ns", "planned_acceleration") if name in _names(fields)
    ]
    if len({fields[name].shape for name in columns}) > 1 or len(columns) == 1:
        return False
    return not silent.any() if columns else bool(silent.all())


def _are_finite(fields: NDArray[Any]) -> bool:
    """Return whether all numbers of messages of one form are finite, and not huge."""
    numbers = [fields[name] for name in _names(fields) if fields[name].dtype.kind == "f"]
    return all(bool((np.abs(each) < _HUGE).all()) for each in numbers)
