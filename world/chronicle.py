"""Entries of `/events`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import EVENTS
from zenvoy.scenarios import NEVER_NS, Scenario, Sine, Switch, Trace, all_faults, name_of

_TARGETS: Final = {
    "desired_gap_m": "desired gap {:g} m",
    "desired_speed_mps": "desired speed {:g} m/s",
    "k_d": "k_d {:g}",
    "k_v": "k_v {:g}",
    "k_c": "k_c {:g}",
}


class Chronicle:
    """Writes scheduled events when they are due, and collisions and fallbacks when they happen."""

    def __init__(self, scenario: Scenario) -> None:
        self._scheduled = sorted(_scheduled(scenario), key=lambda event: event.time_ns)
        self._period_ns = scenario.period_ns

    @property
    def due_ns(self) -> int | None:
        """The time of the next scheduled entry; None if none is left."""
        return self._scheduled[0].time_ns if self._scheduled else None

    def write(
        self, now_ns: int, fallbacks: Iterable[pb.Event], collided: Sequence[int]
    ) -> list[Envelope]:
        """Return the entries for a step of the world to `now_ns`; collided: follower indices."""
        events = list(fallbacks)
        while self._scheduled and self._scheduled[0].time_ns <= now_ns:
            events.append(self._scheduled.pop(0))
        for index in collided:
            events.append(pb.Event(time_ns=now_ns, kind=pb.EVENT_COLLISION, vehicle=index + 1))
        return [self._entry(event) for event in events]

    def brake(self, vehicle: int, span_ns: tuple[int, int], deceleration: float) -> None:
        """Schedule the entries of a brake by hand."""
        text = f"{deceleration:g} m/s², by hand"
        self._scheduled += _spell(vehicle, span_ns, pb.EVENT_BRAKE, pb.EVENT_BRAKE_END, text)
        self._scheduled.sort(key=lambda event: event.time_ns)

    def lose(self, share: float, start_ns: int) -> None:
        """Schedule the entry of a loss by hand."""
        text = f"{100 * share:g} % of all frames besides, by hand"
        self._scheduled.append(pb.Event(time_ns=start_ns, kind=pb.EVENT_LOSS, text=text))
        self._scheduled.sort(key=lambda event: event.time_ns)

    def stop(self, now_ns: int, why: str) -> Envelope:
        """Return the entry of a run that ends early, at `now_ns`."""
        return self._entry(pb.Event(time_ns=now_ns, kind=pb.EVENT_STOPPED, text=why))

    def _entry(self, event: pb.Event) -> Envelope:
        event.cycle = event.time_ns // self._period_ns
        return Envelope(EVENTS, 0, event.SerializeToString(), event.time_ns)


def _scheduled(scenario: Scenario) -> list[pb.Event]:
    events: list[pb.Event] = []
    for switch in scenario.control.schedule:
        at_ns = round(switch.at_s * 1e9)
        whom = "" if switch.vehicles is None else f": {switch.vehicles}"
        if switch.model is not None:
            text = f"{name_of(switch.model)}{whom}"
            events.append(pb.Event(time_ns=at_ns, kind=pb.EVENT_MODEL, text=text))
        if switch.targets:
            text = f"{_targets(switch)}{whom}"
            events.append(pb.Event(time_ns=at_ns, kind=pb.EVENT_TARGET, text=text))
    for brake in scenario.brakes:
        text = f"{brake.deceleration_mps2:g} m/s²"
        span = (brake.start_ns, brake.end_ns)
        events += _spell(brake.vehicle, span, pb.EVENT_BRAKE, pb.EVENT_BRAKE_END, text)
        if brake.return_s is not None:
            span = (brake.end_ns, brake.returned_ns)
            text = "return to its speed before the brake"
            events += _spell(brake.vehicle, span, pb.EVENT_TRACE, pb.EVENT_TRACE_END, text)
    for profile in scenario.profiles:
        span, text = (profile.start_ns, profile.end_ns), _in_words(profile)
        events += _spell(profile.vehicle, span, pb.EVENT_TRACE, pb.EVENT_TRACE_END, text)
    return [*events, *_faults(scenario)]


def _faults(scenario: Scenario) -> Iterator[pb.Event]:
    """Yield begin and end of each fault, once per vehicle; both ends have its text."""
    for _, fault, vehicles in all_faults(scenario):
        for vehicle in vehicles:
            begin = pb.Event(
                time_ns=fault.start_ns, kind=pb.EVENT_FAULT, vehicle=vehicle, text=fault.words
            )
            yield begin
            if fault.end_ns != NEVER_NS:
                end = pb.Event(time_ns=fault.end_ns, kind=pb.EVENT_FAULT_END)
                end.vehicle, end.text = begin.vehicle, begin.text
                yield end


def _targets(switch: Switch) -> str:
    """Return which targets change, and within which time: "desired gap 40 m within 20 s"."""
    said = ", ".join(_TARGETS[name].format(value) for name, value in switch.targets.items())
    return f"{said} within {switch.ramp_s:g} s" if switch.ramp_s else said


def _spell(
    vehicle: int,
    span_ns: tuple[int, int],
    begins: pb.EventKind.ValueType,
    ends: pb.EventKind.ValueType,
    text: str,
) -> tuple[pb.Event, pb.Event]:
    start_ns, end_ns = span_ns
    return (
        pb.Event(time_ns=start_ns, kind=begins, vehicle=vehicle, text=text),
        pb.Event(time_ns=end_ns, kind=ends, vehicle=vehicle),
    )


def _in_words(profile: Sine | Trace) -> str:
    if isinstance(profile, Trace):
        return f"trace of {len(profile.points)} points"
    swing = f"sine, {profile.mean_mps:g} ± {profile.amplitude_mps:g} m/s"
    if profile.to_frequency_hz is None:
        return f"{swing}, {profile.frequency_hz:g} Hz"
    return f"{swing}, {profile.frequency_hz:g} to {profile.to_frequency_hz:g} Hz"
