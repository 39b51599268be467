"""Opens a run to other programs and machines, or refuses to, in a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from zenvoy.cli.terminal import errors, refuse
from zenvoy.fleet.certificates import CertificatesError, doors_of, members_in
from zenvoy.fleet.guests import Guests, GuestsError, guests, open_to_all, require_no_faults
from zenvoy.scenarios import Scenario


def guests_of(
    without: Sequence[int],
    listen: Sequence[str],
    scenario: Scenario,
    certs: Path | None,
    *,
    insecure: bool,
    all_elsewhere: bool = False,
) -> Guests:
    """Return the guests of a run; print what is wrong and exit, or warn of open doors."""
    try:
        size = scenario.fleet.size
        require_no_faults(range(1, size + 1) if all_elsewhere else without, scenario)
        found = guests(without, listen, size, certs, insecure=insecure)
        if certs is not None:
            _ = doors_of(certs, "world"), doors_of(certs, "channel"), members_in(certs)
    except (GuestsError, CertificatesError) as error:
        text = str(error)
        refuse(text.replace("--without", "vehicle", 1) if all_elsewhere else text)
    for endpoint in open_to_all(found.listen):
        errors.print(
            f"warning: {endpoint} is open to anybody on the network, who can read all senses and "
            "command all vehicles"
        )
    return replace(found, all_elsewhere=all_elsewhere)
