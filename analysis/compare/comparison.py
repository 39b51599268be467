"""Compares runs: the differences between their scenarios, and between their results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from zenvoy.analysis.chapters.overview import MERITS, merits
from zenvoy.analysis.compare.pictures import Labelled, comparison_pictures
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spacing import spacing_of, together
from zenvoy.analysis.measures.summary import Summary
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.report import ended, made_by, models, sentence, simulated_s
from zenvoy.analysis.page.section import Cell, Section, Sheet
from zenvoy.bus.log_metadata import versions_of

_ABSENT = "–"
_ROUNDING: Final = 1e-12  # relative; a smaller difference is a rounding error


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A run with its name in the comparison and its summary."""

    label: str
    run: Run
    summary: Summary

    @property
    def fingerprint(self) -> str | None:
        """The run's fingerprint; None where it is not logged or does not match the messages."""
        return self.run.fingerprint


def comparison_page(compared: Sequence[Compared]) -> Page:
    """Return the page without its drawn pictures, for two or more runs that have motion."""
    labels = [each.label for each in compared]
    names = " ".join(each.run.log.name for each in compared)
    return Page(
        title=", ".join(labels[:-1]) + f" and {labels[-1]}",
        lead=f"A comparison of {len(compared)} runs.",
        facts=(("fingerprints", _fingerprints(compared)),),
        notes=(*_caveats(compared), *_notes(compared)),
        sections=comparison(compared),
        made=(made_by(f"zenvoy compare {names}"),),
    )


def comparison(compared: Sequence[Compared]) -> tuple[Section, ...]:
    """Return the scenarios and the results of the runs, in tables and pictures."""
    runs = [Labelled(each.label, each.run) for each in compared]
    return (
        Section(title="Runs", sheets=(_runs(compared), _settings(compared))),
        Section(
            title="Results",
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
        note="The first 16 digits of each fingerprint are shown.",
    )


def _settings(compared: Sequence[Compared]) -> Sheet:
    """Return every setting that is not the same in all scenarios."""
    flat = [dict(_flat(each.run.scenario.model_dump(mode="json"))) for each in compared]
    keys = list(dict.fromkeys(key for settings in flat for key in settings))
    rows = []
    for key in keys:
        cells = [settings.get(key, _ABSENT) for settings in flat]
        if len(set(cells)) > 1 and key != "description":
            rows.append((key, *cells))
    note = "" if rows else "There are none: the scenarios have the same settings."
    columns = ("setting", *(each.label for each in compared))
    title = "Settings in which the scenarios differ"
    return Sheet(name="compare-settings", title=title, columns=columns, rows=tuple(rows), note=note)


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Yield the values of a tree with their paths, such as "control.schedule.0.model"."""
    if isinstance(value, dict | list) and value:
        for name, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _flat(inner, f"{key}.{name}" if key else str(name))
    else:
        yield key, "none" if value is None or value in ([], {}) else str(value)


def _figures(compared: Sequence[Compared]) -> Sheet:
    """Return the figures of the summaries, and the differences of later runs from the first."""
    shown = together([each.run.scenario for each in compared])
    found = [
        {merit[:2]: merit[2] for merit in merits(each.summary, spacing)}
        for each, spacing in zip(compared, shown, strict=True)
    ]
    keys = list(dict.fromkeys(key for values in found for key in values))
    first, later = compared[0].label, [each.label for each in compared[1:]]
    rows = []
    for name, unit in keys:
        cells = [values.get((name, unit)) for values in found]
        rows.append((name, unit, *cells, *(_difference(cell, cells[0]) for cell in cells[1:])))
    return Sheet(
        name="compare-figures",
        title="Figures of the runs, and differences from the first run",
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
    """Yield a sentence on each property that makes figures of the runs hard to compare."""
    properties: dict[str, list[str]] = {
        "simulated time": [f"{simulated_s(each.run):g} s" for each in compared],
        "fleet": [f"{each.run.vehicles} vehicles" for each in compared],
        "road": [each.run.scenario.road.type for each in compared],
        "cycle": [f"{each.run.scenario.period_ms:g} ms" for each in compared],
        "gaps": [spacing_of(each.run.scenario).of_gaps for each in compared],
        "seed": [str(each.run.seed) for each in compared],
        "version of Zenvoy": [
            versions_of(each.run.run).get("zenvoy", "unknown") for each in compared
        ],
    }
    for what, values in properties.items():
        if len(set(values)) > 1:
            pairs = zip(compared, values, strict=True)
            of_each = ", ".join(f"{each.label} {value}" for each, value in pairs)
            shown = " All gaps are shown front to front." if what == "gaps" else ""
            yield f"The runs differ in their {what}: {of_each}.{shown}"


def _notes(compared: Sequence[Compared]) -> Iterator[str]:
    for each in compared:
        for note in each.run.notes:
            yield f"{each.label}: {sentence(note)}"


def _fingerprints(compared: Sequence[Compared]) -> str:
    """Return which runs are equal, bit for bit, in words."""
    alike: dict[str, list[str]] = {}
    for each in compared:
        if each.fingerprint is not None:
            alike.setdefault(each.fingerprint, []).append(each.label)
    if len(alike) == 1 and len(next(iter(alike.values()))) == len(compared):
        return "equal: the logs hold the same data, bit for bit"
    groups = [" = ".join(labels) for labels in alike.values() if len(labels) > 1]
    unknown = [each.label for each in compared if each.fingerprint is None]
    parts = groups or ["no two are equal" if len(alike) > 1 else "cannot be compared"]
    return "; ".join([*parts, *(f"not logged: {label}" for label in unknown)])
