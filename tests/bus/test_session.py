"""A node that joins finds sessions on explicit endpoints, and can query the scenario."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import zenoh

from zenvoy.bus.querying import answer
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import scenario_key
from zenvoy.scenarios import Scenario, effective_json, load


def test_a_node_that_joins_can_query_the_scenario(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path / 'world'}"
    scenario = load("quickstart").scenario
    key = scenario_key("r1")
    with open_session([endpoint], []) as world, open_session([], [endpoint]) as node:
        with answer(world, key, lambda: effective_json(scenario).encode()):
            (reply,) = _ask(node, key)
        assert reply.ok is not None
        assert Scenario.model_validate_json(reply.ok.payload.to_bytes()) == scenario


def _ask(node: zenoh.Session, key: str) -> list[zenoh.Reply]:
    """Return the replies to a query, sent once there is somebody to answer it."""
    with node.declare_querier(key, timeout=30) as querier:
        with querier.declare_matching_listener(zenoh.handlers.FifoChannel(8)) as changes:
            # The stub types the status as a bool; it is an object with a field, always true.
            while not cast(zenoh.MatchingStatus, querier.matching_status).matching:
                changes.recv()
        return list(querier.get())
