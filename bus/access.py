"""Who may do what on the keys of a run: Zenoh's access control, built from the table of topics.

The rules hold for any session that others connect to: the world's, the channel's, or a router's.
From its point of view a member sends (ingress) and is sent (egress).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from zenvoy.bus.topics import (
    OBSERVER,
    TOPICS,
    Topic,
    about_key,
    alive_key,
    host_key,
    processes_key,
    scenario_key,
    time_key,
    vehicle_name,
)
from zenvoy.bus.vehicle_processes import VehicleProcess

SERVERS: Final = ("world", "channel")
"""The roles of a run to which others connect."""

ROUTER: Final = "router"
"""The role of a Zenoh router, which may do nothing on its own account."""

ANY_RUN: Final = "*"
"""Instead of the name of a run: the rules of a router, which outlives runs."""

_NAME: Final = re.compile(
    r"(?P<name>world|channel|router|observer|vehicle-(?P<one>[1-9][0-9]{0,6})"
    r"|vehicles-(?P<first>[1-9][0-9]{0,6})-(?P<last>[1-9][0-9]{0,6}))\.(?P<number>[0-9a-f]{8})",
    re.ASCII,
)
_ALL: Final = (
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "reply",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
)

Rule = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One that may enter: the common name of its certificate, its role and its vehicles.

    The common name ends with a number of its own, so that a certificate that replaces another has
    another name, and the earlier one stays revoked.
    """

    common_name: str
    role: str
    vehicles: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """The name without the number of the certificate, which its files also have."""
        return self.common_name.rpartition(".")[0]


def member_of(common_name: str) -> Member:
    """Return the member with a certificate of this common name; raises ValueError for others."""
    found = _NAME.fullmatch(common_name)
    if found is None:
        raise ValueError(
            f"{common_name[:80]!r} is not the name of a certificate; allowed: world, channel, "
            "router, observer, vehicle-N and vehicles-N-M, each with a point and 8 hexadecimal "
            "digits"
        )
    if found["one"]:
        return Member(common_name=common_name, role="vehicle", vehicles=(int(found["one"]),))
    if found["first"]:
        vehicles = tuple(range(int(found["first"]), int(found["last"]) + 1))
        return Member(common_name=common_name, role="vehicle", vehicles=vehicles)
    return Member(common_name=common_name, role=found["name"])


def access_control(
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    members: Iterable[Member],
    trusted: Sequence[str],
    public: Collection[str] = (),
) -> dict[str, object]:
    """Return Zenoh's settings for access control in a run with a fleet of `size`.

    `shared` are the processes with several vehicles. `trusted` are the protocols of links that may
    carry anything, such as the Unix sockets of this machine. Whoever is neither a member nor on
    such a link may do nothing. `public` are the names of the streams that observers may read.
    """
    rules, subjects, policies = list[Rule](), list[Rule](), list[Rule]()
    if trusted:  # without protocols, the subject would be everybody
        rules.append(_rule("trusted", _ALL, ("ingress", "egress"), ["**"]))
        subjects.append({"id": "trusted", "link_protocols": list(trusted)})
        policies.append({"rules": ["trusted"], "subjects": ["trusted"]})
    for member in members:
        own = list(_rules(member, run, size, shared, public))
        if own:
            name = member.common_name
            rules += own
            subjects.append({"id": name, "cert_common_names": [name]})
            policies.append({"rules": [rule["id"] for rule in own], "subjects": [name]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _rules(
    member: Member,
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    public: Collection[str],
) -> Iterator[Rule]:
    """Yield the rules of a member; those without keys are left out, since Zenoh refuses them."""
    vehicles = [vehicle for vehicle in member.vehicles if vehicle <= size]
    processes = [process.name for process in shared if {*process.vehicles} <= {*vehicles}]
    is_vehicle, is_world = member.role == "vehicle", member.role == "world"
    if member.role == ROUTER or (is_vehicle and not vehicles):
        return
    published = [topic for topic in TOPICS if topic.is_open(public)]
    writes = [topic for topic in published if topic.writer == member.role]
    reads = [topic for topic in published if topic.reader in (member.role, None)]

    def keys(topics: Iterable[Topic[Any]]) -> list[str]:
        found: list[str] = []
        for topic in topics:
            if not (is_vehicle and topic.per_vehicle):
                found.append(topic.keys(run))
                continue
            found += [topic.key(run, vehicle) for vehicle in vehicles]
            found += [topic.shared_key(run, process) for process in processes]
        return found

    names = [*_names(vehicles, run, size), *processes]
    tokens = [alive_key(run, name) for name in (names if is_vehicle else [member.role])]
    tokens += [host_key(run, name) for name in names]
    everyone, world = [alive_key(run)], [alive_key(run, "world")]
    sees = everyone if member.role in SERVERS else world
    if member.role in SERVERS:
        sees = [*everyone, host_key(run)]
    state = [scenario_key(run), processes_key(run), time_key(run), about_key()]
    asks, answers = (state, []) if is_vehicle else ([], state if is_world else [])
    readers = [topic.keys(run) for topic in writes]
    granted = (
        ("put", "ingress", keys(writes)),
        ("put", "egress", keys(reads)),
        ("declare_subscriber", "ingress", keys(reads)),
        ("declare_subscriber", "egress", dict.fromkeys([*keys(writes), *readers])),
        ("liveliness_token", "ingress", tokens if member.role != OBSERVER else []),
        ("liveliness_token", "egress", sees),
        ("declare_liveliness_subscriber", "ingress", sees),
        (
            "declare_liveliness_subscriber",
            "egress",
            dict.fromkeys([*everyone, *world, host_key(run)]),
        ),
        ("query", "ingress", asks),
        ("reply", "egress", asks),
        ("declare_queryable", "egress", asks),
        ("query", "egress", answers),
        ("reply", "ingress", answers),
        ("declare_queryable", "ingress", answers),
    )
    for message, flow, allowed in granted:
        if allowed:
            yield _rule(f"{member.common_name} {message} {flow}", [message], [flow], [*allowed])


def _names(vehicles: Sequence[int], run: str, size: int) -> list[str]:
    """Return the names of the processes of vehicles; in any run, with the digits of any fleet."""
    fleets = [size] if run != ANY_RUN else [10**n - 1 for n in range(2, max(2, len(str(size))) + 1)]
    named = (vehicle_name(one, fleet) for fleet in fleets for one in vehicles if one <= fleet)
    return list(dict.fromkeys(named))


def _rule(name: str, messages: Sequence[str], flows: Sequence[str], keys: Sequence[str]) -> Rule:
    return {
        "id": name,
        "messages": list(messages),
        "flows": list(flows),
        "permission": "allow",
        "key_exprs": list(keys),
    }
