"""Says what the page needs to know about a run before it shows any cycle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.analysis.log.facts import printable, printable_values
from zenvoy.analysis.log.laws import laws_in
from zenvoy.analysis.view.picture import COLUMNS, TOTALS
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import LAWS, RUN
from zenvoy.scenarios import Scenario, modes, name_of

# Colour-blind readers tell these from the colours of laws, which are Okabe and Ito's.
_OTHER_MODES: Final = {
    pb.MODE_UNSPECIFIED: ("no command", "#cccccc"),
    pb.MODE_CONSTANT_SPEED: ("constant speed", "#999999"),
    pb.MODE_FALLBACK_FM: ("fallback to FM", "#000000"),
}


def about(metadata: Mapping[str, Mapping[str, str]], scenario: Scenario) -> dict[str, Any]:
    """Return what does not change during a run, as values that JSON has."""
    run = printable_values(metadata[RUN])
    channel = scenario.channel
    return {
        "scenario": run.get("scenario", ""),
        "run": run.get("run", ""),
        "description": printable(scenario.description),
        "seed": scenario.seed,
        "engine": {"zenoh": "processes"}.get(run.get("bus", ""), run.get("bus", "")),
        "clock": scenario.clock,
        "speed": scenario.speed,
        "vehicles": scenario.fleet.size,
        "cycles": scenario.cycles,
        "period": scenario.period_ns * 1e-9,
        "wait": scenario.v2v_wait_ns * 1e-9,
        "ring": scenario.ring_length_m,
        "length": scenario.fleet.length_m,
        "model": _laws_in_turn(scenario),
        "technology": channel.title or channel.technology.title,
        "columns": COLUMNS,
        "totals": TOTALS,
        "modes": _modes(metadata.get(LAWS, {}), scenario),
        "chosen": _worth_a_look(scenario),
    }


def _modes(laws: Mapping[str, str], scenario: Scenario) -> dict[int, tuple[str, str]]:
    """Return name and colour of each mode that vehicles of the scenario may be in."""
    named = modes(scenario)
    try:
        found = laws_in(laws, named)
    except ValueError:  # a damaged log; `zenvoy info` says so
        found = laws_in({}, named)
    shown = {mode: (printable(law.name), law.colour or "#999999") for mode, law in found.items()}
    return shown | _OTHER_MODES


def _laws_in_turn(scenario: Scenario) -> str:
    """Return the laws of the fleet in the order of the schedule, without those of groups."""
    control = scenario.control
    later = [switch.model for switch in control.schedule if switch.vehicles is None]
    names = [name_of(model) for model in (control.model, *later) if model is not None]
    return " → ".join(dict.fromkeys(names))


def _worth_a_look(scenario: Scenario) -> list[int]:
    """Return the vehicle to which something happens, or one in the middle of the fleet."""
    acting = [event.vehicle for event in scenario.events]
    first = acting[0] if acting else (scenario.fleet.size + 1) // 2
    if scenario.road.type == "open" and first == 1:
        return [2]  # the first vehicle has no gap
    return [first]
