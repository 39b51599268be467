"""Helpers drive one agent in real time without the others."""

from __future__ import annotations

from typing import Any

from zenvoy.bus.realtime_agent import Post, RealtimeAgent
from zenvoy.bus.topics import Topic


def post(topic: Topic[Any], vehicle: int, came_ns: int, message: Any) -> Post:
    return Post(topic, vehicle, message, message.SerializeToString(), came_ns)


def due(agent: RealtimeAgent) -> int | None:
    """Return when an agent acts next. A function keeps mypy from narrowing the attribute."""
    return agent.due_ns
