"""The doorman understands Zenoh's log, and counts whom Zenoh has refused."""

from __future__ import annotations

import pytest

from zenvoy.bus.doorkeeper import NO_CERTIFICATE, UNAUTHORIZED, Doorman
from zenvoy.bus.refusals import Refusals

ACL = "\x1b[2m2026-11-27T07:22:50Z\x1b[0m TRACE {thread} ThreadId(03) zenoh::net::routing::"
RULES = f"{ACL.format(thread='app-1')}interceptor::access_control: "
WHO = "b3ec on Interface(lo)+CertCommonName(vehicle-2.a5fddc3c)+Transport(Tls)+b3ec"
ACTIONS = ("Query", "Reply", "Put", "Delete", *("Declare/Undeclare Subscriber",) * 5)


def verdict(action: str, key: str, flow: str = "ingress", un: str = "un") -> str:
    """Return a line of Zenoh's log on one message."""
    return f"{RULES}{WHO} is {un}authorized to {action} ({flow}) on {key}"


def block(key: str, allowed: int = 0) -> list[str]:
    """Return the lines on a key that is new to Zenoh, whose first actions are allowed."""
    lines = [f"{RULES}ACL (ingress): caching permissions for `{key}` ..."]
    for number, action in enumerate(ACTIONS):
        lines.append(verdict(action, key, un="" if number < allowed else "un"))
    return lines


@pytest.fixture
def refusals(capsys: pytest.CaptureFixture[str]) -> Refusals:
    return Refusals("world")


def read(refusals: Refusals, *lines: str) -> dict[str, int]:
    """Let a doorman read the lines; return what it counts."""
    doorman = Doorman("r", refusals)
    for line in lines:
        doorman.read(line)
    return dict(refusals.counts)


def test_a_message_on_a_foreign_key_is_told_with_its_sender(
    refusals: Refusals, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (verdict("Put", "zenvoy/r/vehicle/3/command"), *block("zenvoy/r/vehicle/3/beacon"))
    assert read(refusals, *lines) == {UNAUTHORIZED: 2}
    assert capsys.readouterr().err == (
        "world: refused: unauthorized, on 'zenvoy/r/vehicle/3/command by vehicle-2.a5fddc3c'\n"
        "world: refused: unauthorized, on 'zenvoy/r/vehicle/3/beacon by vehicle-2.a5fddc3c'\n"
    )


def test_what_a_member_may_do_is_not_told(refusals: Refusals) -> None:
    lines = [
        *block("zenvoy/r/vehicle/2/command", allowed=1),
        *block("zenvoy/r"),
        *block("zenvoy/r/channel/links"),
        verdict("Put", "zenvoy/r/vehicle/2/sense", flow="egress"),
        verdict("Put", "zenvoy/r/vehicle/2/command", un=""),
        "",
        "rubbish",
    ]
    assert read(refusals, *lines) == {}


@pytest.mark.parametrize(
    "why", ["peer sent no certificates", "invalid peer certificate: UnknownIssuer"]
)
def test_a_refused_connection_is_told_with_the_reason(
    refusals: Refusals, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    hint = "Hint: increase the system open file limit."
    line = f"2026-11-27T07:22:50Z  WARN app-1 ThreadId(03) zenoh_link_tls::unicast: {why}. {hint}"
    assert read(refusals, line) == {NO_CERTIFICATE: 1}
    assert capsys.readouterr().err == f"world: refused: connection, on {why!r}\n"


def test_a_stranger_with_a_certificate_is_told(refusals: Refusals) -> None:
    line = f"{RULES}b3ec did not match any configured ACL subject. Default permission `Deny`"
    assert read(refusals, line) == {NO_CERTIFICATE: 1}
