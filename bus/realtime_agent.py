"""Participants in real time: plain objects that act when a time has come, and read no clock.

`agent` has those of lock-step, which step when their messages have come.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, Protocol

from zenvoy.bus.agent import Envelope, Participant
from zenvoy.bus.refusals import EARLY
from zenvoy.bus.topics import Topic

ROUNDING_NS: Final = 1_000_000
"""How far before its own time a message may arrive, ns, because times are rounded."""


class Post(NamedTuple):
    """A message, and when it arrived (ns of simulation time)."""

    topic: Topic[Any]
    vehicle: int
    message: Any
    payload: bytes
    came_ns: int


class RealtimeAgent(Participant, Protocol):
    """A participant in real time. All times that it gets are simulation time, ns."""

    may_wait: frozenset[Topic[Any]]
    """Streams whose messages may wait until it acts; one alone does not wake the process."""

    sends_together: bool
    """Whether the results of several acts due at the same time are sent together."""

    @property
    def due_ns(self) -> int | None:
        """When it acts next (at once if that has passed); None: after the next message."""

    @property
    def done(self) -> bool:
        """Whether it has finished this run."""

    def take_in(self, post: Post) -> str | None:
        """Keep a message, or return the reason why it is refused, such as that it is stale."""

    def act(self, now_ns: int) -> list[Envelope]:
        """Do what is due, and return what it sends, in order."""


def admit(agent: RealtimeAgent, post: Post, early_ns: int = ROUNDING_NS) -> str | None:
    """Hand an agent a message that has passed the checks; return the reason if it is refused.

    A message with a time in the future is refused: after it, the agent would treat all earlier ones
    as stale. `early_ns` is how far before its own time a message may arrive.
    """
    if post.message.time_ns > post.came_ns + early_ns:
        return EARLY
    return agent.take_in(post)
