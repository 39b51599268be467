"""Zenoh's access control lets each member use its own keys, as the table of topics says."""

from __future__ import annotations

from typing import Any, Final

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.access import Member, access_control, member_of
from zenvoy.bus.topics import (
    TOPICS,
    TRUTH,
    about_key,
    alive_key,
    host_key,
    processes_key,
    scenario_key,
    time_key,
    vehicle_name,
)
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes

SIZE: Final = 12
NAMES: Final = ("world", "channel", "observer", "vehicle-3", "vehicle-7", "vehicles-5-8")
MEMBERS: Final = {name: member_of(f"{name}.0123abcd") for name in NAMES}
UNIX: Final = "unixsock-stream"
PUBLIC: Final = (TRUTH.name,)
SHARED: Final = tuple(one for one in vehicle_processes(SIZE, 4) if one.is_shared)


def allows(name: str, message: str, flow: str, key: str, public: tuple[str, ...] = PUBLIC) -> bool:
    """Return whether the rules of a member allow a message on a key, by Zenoh's own inclusion."""
    config: Any = access_control("r", SIZE, SHARED, MEMBERS.values(), [UNIX], public)
    rules = {rule["id"]: rule for rule in config["rules"]}
    common_name = MEMBERS[name].common_name
    subjects = {one["id"] for one in config["subjects"] if common_name in one.get(CERT, ())}
    of = [
        rules[rule]
        for one in config["policies"]
        if subjects & {*one["subjects"]}
        for rule in one["rules"]
    ]
    return any(
        message in rule["messages"]
        and flow in rule["flows"]
        and any(
            zenoh.KeyExpr(allowed).includes(zenoh.KeyExpr(key)) for allowed in rule["key_exprs"]
        )
        for rule in of
    )


CERT: Final = "cert_common_names"


def keys_of(member: Member, *, written: bool) -> set[str]:
    """Return the keys that the table of topics gives to a member, with its shared process."""
    keys = set()
    for topic in TOPICS:
        if not topic.is_open(PUBLIC):
            continue
        mine = topic.writer == member.role if written else topic.reader in (member.role, None)
        if not mine:
            continue
        if not topic.per_vehicle:
            keys.add(topic.key("r"))
            continue
        everyone = range(1, SIZE + 1)
        vehicles = member.vehicles if member.role == "vehicle" else everyone
        keys |= {topic.key("r", vehicle) for vehicle in vehicles}
        for process in SHARED:
            if set(process.vehicles) <= set(vehicles):
                keys.add(topic.shared_key("r", process.name))
    return keys


ALL_KEYS: Final = sorted(
    set().union(*(keys_of(MEMBERS[name], written=way) for name in NAMES for way in (True, False)))
)


@given(st.sampled_from(NAMES), st.sampled_from(ALL_KEYS))
def test_a_member_puts_what_it_writes_and_reads_what_is_meant_for_it(name: str, key: str) -> None:
    member = MEMBERS[name]
    writes, reads = keys_of(member, written=True), keys_of(member, written=False)
    assert allows(name, "put", "ingress", key) == (key in writes)
    assert allows(name, "put", "egress", key) == (key in reads)
    assert allows(name, "declare_subscriber", "ingress", key) == (key in reads)
    assert not allows(name, "delete", "ingress", key)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("public", [(), PUBLIC])
def test_only_an_observer_reads_the_truth_and_only_if_it_is_public(
    name: str, public: tuple[str, ...]
) -> None:
    reads = name == "observer" and bool(public)
    for message, flow in (("put", "egress"), ("declare_subscriber", "ingress")):
        assert allows(name, message, flow, TRUTH.key("r"), public) == reads
    assert allows(name, "put", "ingress", TRUTH.key("r"), public) == (
        name == "world" and bool(public)
    )


@pytest.mark.parametrize("name", ["vehicle-3", "vehicles-5-8", "observer"])
@pytest.mark.parametrize("key", ["zenvoy/r/**", "zenvoy/**", "**", "zenvoy/r/*/*/sense"])
def test_nobody_without_a_fleet_reads_or_puts_on_wildcards(name: str, key: str) -> None:
    for message in ("put", "declare_subscriber", "query", "declare_liveliness_subscriber"):
        assert not allows(name, message, "ingress", key)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("other", [*range(1, SIZE + 1)])
def test_a_member_shows_no_token_but_its_own(name: str, other: int) -> None:
    token = alive_key("r", vehicle_name(other, SIZE))
    own = MEMBERS[name].vehicles
    assert allows(name, "liveliness_token", "ingress", token) == (other in own)
    assert allows("observer", "liveliness_token", "ingress", token) is False
    on = host_key("r", vehicle_name(other, SIZE), "beta")
    assert allows(name, "liveliness_token", "ingress", on) == (other in own)


@pytest.mark.parametrize(
    "key", [scenario_key("r"), processes_key("r"), time_key("r"), about_key("r")]
)
def test_only_vehicles_ask_and_only_the_world_answers(key: str) -> None:
    asking = {name for name in NAMES if allows(name, "query", "ingress", key)}
    assert asking == {"vehicle-3", "vehicle-7", "vehicles-5-8"}
    answering = {name for name in NAMES if allows(name, "declare_queryable", "ingress", key)}
    assert answering == {"world"}


def test_only_vehicles_find_the_runs_there_are() -> None:
    asking = {name for name in NAMES if allows(name, "query", "ingress", about_key())}
    assert asking == {"vehicle-3", "vehicle-7", "vehicles-5-8"}


def test_a_vehicle_beyond_the_fleet_has_no_rules() -> None:
    config: Any = access_control("r", 2, (), [MEMBERS["vehicle-7"]], ["unixsock-stream"])
    assert [one["id"] for one in config["subjects"]] == ["trusted"]
    assert config["default_permission"] == "deny"


@pytest.mark.parametrize("name", ["", "world", "vehicle-07.0123abcd", "vehicle-0.0123abcd", "x.1"])
def test_another_common_name_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="is not the name of a certificate; allowed: world, "):
        member_of(name)


def test_the_processes_of_a_group_are_those_within_it() -> None:
    assert SHARED[1] == VehicleProcess("vehicles-05-08", (5, 6, 7, 8))
    assert allows("vehicles-5-8", "put", "ingress", "zenvoy/r/process/vehicles-05-08/command")
    assert not allows("vehicles-5-8", "put", "ingress", "zenvoy/r/process/vehicles-01-04/command")
    assert not allows("vehicle-7", "put", "ingress", "zenvoy/r/process/vehicles-05-08/command")
