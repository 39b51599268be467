"""Messages of a bundle are decoded together if there are several, of different vehicles."""

from __future__ import annotations

import pytest

from zenvoy.bus.agent import decoded_jointly
from zenvoy.bus.bundles import Parcel


@pytest.mark.parametrize(
    ("parcels", "together"),
    [
        ([], False),
        ([(1, b"a")], False),
        ([(1, b"a"), (2, b"b")], True),
        ([(1, b"a"), (2, b"b"), (1, b"a")], False),  # a mailbox tells which is the duplicate
    ],
)
def test_parcels_of_different_vehicles_are_decoded_together(
    parcels: list[Parcel], together: bool
) -> None:
    assert (decoded_jointly(list, parcels) == parcels) == together
    assert (decoded_jointly(list, parcels) is None) != together
    assert decoded_jointly(None, parcels) is None
