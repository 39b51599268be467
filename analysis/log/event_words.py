"""Says in words what the events of a log are, for everything that lists them."""

from __future__ import annotations

from typing import Final

from zenvoy.bus import messages_pb2 as pb

_WORDS: Final = {
    pb.EVENT_BRAKE: "brakes",
    pb.EVENT_BRAKE_END: "stops braking",
    pb.EVENT_MODEL: "law",
    pb.EVENT_COLLISION: "collides with the vehicle ahead",
    pb.EVENT_FALLBACK: "falls back to FM",
    pb.EVENT_FALLBACK_END: "returns to its law",
    pb.EVENT_PROCESS_LOST: "process lost",
    pb.EVENT_PROCESS_BACK: "process back",
    pb.EVENT_STOPPED: "the run is stopped",
    pb.EVENT_TRACE: "follows a trace",
    pb.EVENT_TRACE_END: "ends its trace",
    pb.EVENT_SILENT: "sends no commands",
    pb.EVENT_SILENT_END: "sends commands again",
    pb.EVENT_TARGET: "target",
    pb.EVENT_FAULT: "has a fault",
    pb.EVENT_FAULT_END: "no longer has the fault",
    pb.EVENT_LOSS: "loss",
}
_NAMED: Final = {pb.EVENT_FAULT, pb.EVENT_FAULT_END}  # their text says which it is


def event_words(event: pb.Event) -> str:
    """Return what happens and to whom: "vehicle 5 brakes, 3 m/s²", "law: FM"."""
    what = _WORDS.get(event.kind, "unknown event")
    who = f"vehicle {event.vehicle} " if event.vehicle else ""
    between = ", " if event.vehicle and event.kind not in _NAMED else ": "
    return f"{who}{what}{between if event.text else ''}{event.text}"
