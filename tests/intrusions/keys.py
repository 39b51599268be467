"""Certificates for intruders: proper ones, and those that a run must refuse."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from zenvoy.bus.access import member_of
from zenvoy.fleet.authority import Authority, Validity, make_certificates, validity_of
from zenvoy.fleet.certificates import MEMBERS

SIZE: Final = 4
HOSTS: Final = ("localhost", "127.0.0.1")
REVOKED: Final = "vehicle-1"
_NAMES: Final = (
    "world",
    "channel",
    "router",
    "observer",
    *(f"vehicle-{i}" for i in range(1, SIZE + 1)),
)


def make_keys(folder: Path) -> None:
    """Make folders of certificates: `keys` is that of the run, the others are of intruders.

    `others` has another authority, `expired` and `early` have certificates of the run's authority
    that are not valid now, `unlisted` one that never was in the list. In `keys`, the certificate of
    vehicle 1 is revoked; the run has a vehicle 1 of its own.
    """
    made = make_certificates(folder / "keys", _NAMES, HOSTS, validity_of(2))
    make_certificates(folder / "others", _NAMES, HOSTS, validity_of(2))
    for name in ("expired", "early", "unlisted"):
        (folder / name).mkdir()
    now, day = datetime.now(UTC), timedelta(days=1)
    authority = Authority.opened(folder / "keys", validity_of(2))
    listed = (folder / "keys" / MEMBERS).read_text()
    for where, begin, end in (("expired", -2, -1), ("early", 1, 2)):
        late = Validity(begin=now + begin * day, end=now + end * day)
        member = member_of(f"vehicle-3.{len(where):08x}")
        authority.issue(member, folder / where, HOSTS, late)
        listed += f"{member.common_name}\n"  # only its dates keep it out
    stranger = member_of("vehicle-3.ffffffff")
    authority.issue(stranger, folder / "unlisted", HOSTS, validity_of(2))
    revoked = next(member.common_name for member in made if member.name == REVOKED)
    (folder / "keys" / MEMBERS).write_text(listed.replace(f"{revoked}\n", ""))
