"""Communication between participants: messages, topics, clock, and two buses for agents."""

from zenvoy.bus.agent import Agent, Barrier, Envelope, Inbox
from zenvoy.bus.errors import BusError, PayloadError, StalledError, StoppedError
from zenvoy.bus.in_process import InProcessBus

__all__ = [
    "Agent",
    "Barrier",
    "BusError",
    "Envelope",
    "InProcessBus",
    "Inbox",
    "PayloadError",
    "StalledError",
    "StoppedError",
]
