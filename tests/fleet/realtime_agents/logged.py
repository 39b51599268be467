"""Helpers read what a run in virtual time logs."""

from __future__ import annotations

from typing import Any

from tests.fleet.realtime_agents.runs import of
from tests.virtual_time import Logged
from zenvoy.bus import messages_pb2 as pb


def rows(topic: str, kind: Any, logged: Logged) -> list[Any]:
    """Return the messages of a topic."""
    return [kind.FromString(payload) for _, payload in of(topic, logged)]


def fates(logged: Logged) -> dict[tuple[int, int, int], tuple[bool, int]]:
    """Return whether each frame (source, destination, sequence) is lost, and its latency."""
    return {
        (source, destination, sequence): (outcome == pb.OUTCOME_LOST, latency_ns)
        for frames in rows("/v2v/frames", pb.Frames, logged)
        for source, destination, sequence, outcome, latency_ns in zip(
            frames.source,
            frames.destination,
            frames.sequence,
            frames.outcome,
            frames.latency_ns,
            strict=True,
        )
    }
