"""Which samples become messages: those on known keys, whole, not empty, and of their owners."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Any

import zenoh

from zenvoy.bus.bundles import Parcel, parcels_in
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.parts import Joiner
from zenvoy.bus.refusals import FOREIGN, MALFORMED, Refusals
from zenvoy.bus.streams import Owner
from zenvoy.bus.topics import Topic


class Admission:
    """Admits samples, and counts those that it refuses.

    owners: the owner of each key, by topic. whole: topics whose bundles are decoded as they are.
    """

    def __init__(
        self,
        owners: Mapping[Topic[Any], Mapping[str, Owner]],
        whole: Container[Topic[Any]],
        refusals: Refusals,
    ) -> None:
        self._owners = owners
        self._whole = whole
        self._refusals = refusals
        self._joiner = Joiner()

    def parcels(self, topic: Topic[Any], key: str, sample: zenoh.Sample) -> Sequence[Parcel]:
        """Return the vehicles and payloads of a sample; none for a part, or if it is refused."""
        owner = self._owners[topic].get(key)
        if owner is None:
            self._refusals.add(FOREIGN, key)
            return ()
        payload = sample.payload.to_bytes()
        attachment = sample.attachment
        try:
            if attachment is not None:
                whole = self._joiner.join(key, payload, attachment.to_bytes())
                if whole is None:
                    return ()
                payload = whole
            parcels = self._parcels_in(topic, owner, payload)
        except PayloadError:
            self._refusals.add(MALFORMED, key)
            return ()
        # A deletion has an empty payload, which protobuf would read as a message of zeros.
        if not parcels or not all(payload for _, payload in parcels):
            self._refusals.add(MALFORMED, key)
            return ()
        owners = {owner} if isinstance(owner, int) else owner
        taken_apart = topic not in self._whole
        if taken_apart and not owners.issuperset(vehicle for vehicle, _ in parcels):
            self._refusals.add(FOREIGN, key)
            return ()
        return parcels

    def _parcels_in(self, topic: Topic[Any], owner: Owner, payload: bytes) -> list[Parcel]:
        """Return the payloads in a message by vehicle; a bundle that stays whole has number 0."""
        if isinstance(owner, int):
            return [(owner, payload)]
        return [(0, payload)] if topic in self._whole else parcels_in(topic, payload)
