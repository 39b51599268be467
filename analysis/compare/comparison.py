"""Runs beside each other: what differs in what was asked for, and in what came of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from zenvoy.analysis.chapters.overview import MERITS, merits
from zenvoy.analysis.compare.pictures import Labelled, comparison_pictures
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.summary import Summary
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.report import ended, made_by, models, sentence, simulated_s
from zenvoy.analysis.page.section import Cell, Section, Sheet
from zenvoy.bus.log_metadata import versions_of

_ABSENT = "–"
_ROUNDING: Final = 1e-12  # of a figure: less is no difference of runs


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A run under the name it has in a comparison, and its summary."""

    label: str
    run: Run
    summary: Summary

    @property
    def fingerprint(self) -> str | None:
        """SHA-256 over the data of the log; None where the log is cut before it."""
        return self.run.fingerprint


def comparison_page(compared: Sequence[Compared]) -> Page:
    """Everything on the page but the drawn pictures; of two runs or more, each with motion."""
    labels = [each.label for each in compared]
    names = " ".join(each.run.path.name for each in compared)
    return Page(
        title=", ".join(labels[:-1]) + f" and {labels[-1]}",
        lead=f"A comparison of {len(compared)} runs.",
        facts=(("fingerprints", _fingerprints(compared)),),
        notes=(*_caveats(compared), *_notes(compared)),
        sections=comparison(compared),
        made=(made_by(f"zenvoy compare {names}"),),
    )


def comparison(compared: Sequence[Compared]) -> tuple[Section, ...]:
    """What was asked for, and what came of it, in tables and in pictures."""
    runs = [Labelled(each.label, each.run) for each in compared]
    return (
        Section(title="Runs", sheets=(_runs(compared), _settings(compared))),
        Section(
            title="What came of them",
            sheets=(_figures(compared),),
            pictures=comparison_pictures(runs),
        ),
    )


def _runs(compared: Sequence[Compared]) -> Sheet:
    return Sheet(
        name="compare-runs",
        title="The runs",
        columns=("run", "scenario", "seed", "vehicles", "model", "time, s", "end", "fingerprint"),
        rows=tuple(
            (
                each.label,
                each.run.name,
                str(each.run.seed),
                each.run.vehicles,
                models(each.run.scenario),
                simulated_s(each.run),
                ended(each.run),
                each.fingerprint and each.fingerprint[:16],
            )
            for each in compared
        ),
        note="Of the fingerprint, the first 16 digits.",
    )


def _settings(compared: Sequence[Compared]) -> Sheet:
    """Every setting of the scenarios that is not the same in all runs."""
    flat = [dict(_flat(each.run.scenario.model_dump(mode="json"))) for each in compared]
    keys = list(dict.fromkeys(key for settings in flat for key in settings))
    rows = []
    for key in keys:
        cells = [settings.get(key, _ABSENT) for settings in flat]
        if len(set(cells)) > 1 and key != "description":
            rows.append((key, *cells))
    note = "" if rows else "There is none: the scenarios ask for the same."
    columns = ("setting", *(each.label for each in compared))
    title = "Settings in which the scenarios differ"
    return Sheet(name="compare-settings", title=title, columns=columns, rows=tuple(rows), note=note)


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Values of a tree by their paths, "control.schedule.0.model"."""
    if isinstance(value, dict | list) and value:
        for name, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _flat(inner, f"{key}.{name}" if key else str(name))
    else:
        yield key, "none" if value is None or value in ([], {}) else str(value)


def _figures(compared: Sequence[Compared]) -> Sheet:
    """The figures of the summaries, and how those of the later runs differ from the first's."""
    found = [{merit[:2]: merit[2] for merit in merits(each.summary)} for each in compared]
    keys = list(dict.fromkeys(key for values in found for key in values))
    first, later = compared[0].label, [each.label for each in compared[1:]]
    rows = []
    for name, unit in keys:
        cells = [values.get((name, unit)) for values in found]
        rows.append((name, unit, *cells, *(_difference(cell, cells[0]) for cell in cells[1:])))
    return Sheet(
        name="compare-figures",
        title="Figures of the runs, and their differences from those of the first",
        columns=(
            "figure",
            "unit",
            *(each.label for each in compared),
            *(f"{label} − {first}" for label in later),
        ),
        rows=tuple(rows),
        note=MERITS,
    )


def _difference(cell: Cell, first: Cell) -> Cell:
    if isinstance(cell, int | float) and isinstance(first, int | float):
        difference = cell - first
        rounding = abs(difference) <= _ROUNDING * max(abs(cell), abs(first))
        return type(difference)(0) if rounding else difference
    return None


def _caveats(compared: Sequence[Compared]) -> Iterator[str]:
    """In what the runs cannot be compared figure by figure."""
    told: dict[str, list[str]] = {
        "simulated time": [f"{simulated_s(each.run):g} s" for each in compared],
        "fleet": [f"{each.run.vehicles} vehicles" for each in compared],
        "road": [each.run.scenario.road.type for each in compared],
        "cycle": [f"{each.run.scenario.period_ms:g} ms" for each in compared],
        "seed": [str(each.run.seed) for each in compared],
        "version of Zenvoy": [
            versions_of(each.run.run).get("zenvoy", "unknown") for each in compared
        ],
    }
    for what, values in told.items():
        if len(set(values)) > 1:
            pairs = zip(compared, values, strict=True)
            of_each = ", ".join(f"{each.label} {value}" for each, value in pairs)
            yield f"The runs differ in their {what}: {of_each}."


def _notes(compared: Sequence[Compared]) -> Iterator[str]:
    for each in compared:
        for note in each.run.notes:
            yield f"{each.label}: {sentence(note)}"


def _fingerprints(compared: Sequence[Compared]) -> str:
    """Which runs are the same to the bit."""
    alike: dict[str, list[str]] = {}
    for each in compared:
        if each.fingerprint is not None:
            alike.setdefault(each.fingerprint, []).append(each.label)
    if len(alike) == 1 and len(next(iter(alike.values()))) == len(compared):
        return "equal: the logs tell the same, bit for bit"
    groups = [" = ".join(labels) for labels in alike.values() if len(labels) > 1]
    unknown = [each.label for each in compared if each.fingerprint is None]
    parts = groups or ["no two are equal" if len(alike) > 1 else "not to be compared"]
    return "; ".join([*parts, *(f"not logged: {label}" for label in unknown)])
