"""What a router lets through, and what a run through a router refuses before it starts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.conftest import zenvoy
from tests.fleet.joining import free_ports
from zenvoy.bus.access import ANY_RUN, access_control, member_of
from zenvoy.fleet.guests import GuestsError, guests


def test_a_router_that_is_not_there_is_told(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_ports()[0]}"
    outcome = zenvoy(tmp_path, "run", "quickstart", "--router", endpoint)
    assert outcome.code == 2
    assert outcome.err.startswith(f"--router: no session with the router {endpoint}: ")
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("listen", "endpoint", "certs", "text"),
    [
        (["tcp/127.0.0.1:1"], "tcp/127.0.0.1:2", None, "--listen tcp/127.0.0.1:1: with --router "),
        ([], "tls/r:7447", None, "--router tls/r:7447: needs --certs DIR"),
        ([], "tcp/r:7447", None, "--router tcp/r:7447: lets anybody on the network in; allowed: "),
        ([], "udp/r:7447", None, "--router udp/r:7447: is not tls/<host>:<port>"),
        ([], "tcp/127.0.0.1:7447", Path("c"), "--certs c: needs an endpoint with TLS"),
    ],
)
def test_what_a_router_does_not_go_with_is_refused(
    listen: list[str], endpoint: str, certs: Path | None, text: str
) -> None:
    with pytest.raises(GuestsError) as refused:
        guests((), listen, 8, certs, router=endpoint)
    assert str(refused.value).startswith(text)


def test_a_routers_rules_hold_for_fleets_of_any_digits_and_for_nobody_else() -> None:
    members = [member_of(f"{name}.0123abcd") for name in ("vehicle-3", "router", "world")]
    config: Any = access_control(ANY_RUN, 1000, (), members, ())
    subjects = [one["id"] for one in config["subjects"]]
    assert subjects == ["vehicle-3.0123abcd", "world.0123abcd"]  # no protocol is trusted
    tokens = next(
        one for one in config["rules"] if "3.0123abcd liveliness_token ingress" in one["id"]
    )
    shown = [key for key in tokens["key_exprs"] if "/alive/" in key]
    assert shown == [f"zenvoy/*/alive/vehicle-{digits}" for digits in ("03", "003", "0003")]
