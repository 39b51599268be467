"""The report of one run as a page that can be sent to a colleague."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from importlib.metadata import version
from itertools import pairwise
from typing import Final

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.section import Section
from zenvoy.bus.log_metadata import versions_of
from zenvoy.scenarios import Scenario, effective_yaml, roster
from zenvoy.values.wording import capitalized

_BUSES: Final = {
    "zenoh": "a process per vehicle, on Zenoh",
    "in-process": "all vehicles in one process, without Zenoh",
    "arrays": "all vehicles as arrays in one process, without messages",
}


def report_page(run: Run, sections: tuple[Section, ...]) -> Page:
    """Return the page without its drawn pictures; it depends only on the log, not on its folder."""
    return Page(
        title=f"{run.name}, seed {run.seed}",
        lead=run.scenario.description,
        facts=facts_of(run),
        notes=tuple(map(sentence, run.notes)),
        sections=sections,
        folded=(("The scenario with all its values", effective_yaml(run.scenario)),),
        made=(made_by(f"zenvoy analyze {run.log.name}"),),
    )


def made_by(command: str) -> str:
    """Return how a page was made, without a date, so that equal logs give equal pages."""
    return f"Made with: {command}  (Zenvoy {version('zenvoy')}, matplotlib {version('matplotlib')})"


def facts_of(run: Run) -> tuple[tuple[str, str], ...]:
    """Return what the log says about its run, as names and values."""
    versions = [f"{name} {version}" for name, version in versions_of(run.run).items()]
    return (
        ("vehicles", f"{run.vehicles}, {_road(run.scenario)}"),
        ("model", models(run.scenario)),
        (
            "channel",
            f"{run.scenario.channel.technology.name}, {run.scenario.channel.frame_bytes} bytes",
        ),
        ("duration", _duration(run)),
        ("how it ended", ended(run)),
        ("fingerprint", run.fingerprint or ("does not match" if run.result else "not logged")),
        ("run", f"{run.run['run']}: {_BUSES.get(run.run['bus'], run.run['bus'])}"),
        ("speed of the run", _speed(run)),
        ("versions", ", ".join([*versions, f"Python {run.run['python']}"])),
        ("machine", run.run["machine"]),
    )


def models(scenario: Scenario) -> str:
    """Return the models of a scenario, with the times of switches, and how many vehicles run each.

    Examples are "FM, PBCM from 10 s" and "PBCM (36 vehicles); FM (4 vehicles)".
    """
    programs = Counter(_program(settings.program) for settings in roster(scenario))
    if len(programs) == 1:
        return next(iter(programs))
    return "; ".join(f"{text} ({number} vehicles)" for text, number in programs.most_common())


def _program(phases: Sequence[tuple[int, str]]) -> str:
    changes = [
        f"{new} from {at_ns * 1e-9:g} s"
        for (_, old), (at_ns, new) in pairwise(phases)
        if old != new
    ]
    return ", ".join([phases[0][1], *changes])


def ended(run: Run) -> str:
    """Return how the run ended, according to its log."""
    return run.result.get("end", "not logged")


def simulated_s(run: Run) -> float:
    """Return the simulated time that the log covers, s."""
    return float(run.time_s[-1]) if len(run.time_s) else 0.0


def sentence(note: str) -> str:
    """Return a note with a capital letter at its start and a full stop at its end."""
    return capitalized(note) + ("" if note.endswith((".", "!", "?")) else ".")


def _road(scenario: Scenario) -> str:
    length_m = scenario.ring_length_m
    return "on an open road" if length_m is None else f"on a ring of {length_m:g} m"


def _duration(run: Run) -> str:
    asked_s, period_ms = run.scenario.duration_s, run.scenario.period_ms
    done_s = simulated_s(run)
    text = f"{done_s:g} s" if done_s >= asked_s else f"{done_s:g} s of {asked_s:g} s"
    return f"{text}, in cycles of {period_ms:g} ms"


def _speed(run: Run) -> str:
    if not {"wall_s", "real_time_factor"} <= run.result.keys():
        return "not logged"
    wall_s, factor = (float(run.result[name]) for name in ("wall_s", "real_time_factor"))
    return f"{wall_s:.1f} s of wall time, {factor:.1f} × real time"
