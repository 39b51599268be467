"""Every kind of event has words, and lists of events show them as sentences."""

from __future__ import annotations

import pytest

from zenvoy.analysis.log.event_words import event_words
from zenvoy.bus import messages_pb2 as pb


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (pb.Event(kind=pb.EVENT_BRAKE, vehicle=5, text="3 m/s²"), "vehicle 5 brakes, 3 m/s²"),
        (pb.Event(kind=pb.EVENT_BRAKE_END, vehicle=5), "vehicle 5 stops braking"),
        (pb.Event(kind=pb.EVENT_MODEL, text="FM: 2-4"), "law: FM: 2-4"),
        (pb.Event(kind=pb.EVENT_FAULT, vehicle=6, text="blind"), "vehicle 6 has a fault: blind"),
        (pb.Event(kind=pb.EVENT_PROCESS_LOST, text="vehicle-07"), "process lost: vehicle-07"),
        (pb.Event(kind=pb.EVENT_STOPPED, text="asked to end"), "the run is stopped: asked to end"),
    ],
)
def test_events_are_sentences(event: pb.Event, words: str) -> None:
    assert event_words(event) == words


def test_every_kind_has_words() -> None:
    kinds = set(pb.EventKind.values()) - {pb.EVENT_UNSPECIFIED}
    words = {event_words(pb.Event(kind=kind)) for kind in kinds}
    assert len(words) == len(kinds)
    assert event_words(pb.Event()) not in words
