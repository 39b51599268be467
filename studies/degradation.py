"""The study of bilateral control over channels that get worse."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Final

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.paper.degradation import IMPAIRMENTS, MODELS, Point, picture, sheet
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.studies.cell import Cell
from zenvoy.studies.study import Study

_SCENARIO: Final = "paper/case-15"
_DURATION_S: Final = 120.0
_LOST: Final = 0.3  # fraction of frames lost in the study of bursts
_NEVER_MS: Final = 1e6  # an age that no beacon reaches


def plan(seeds: int, duration_s: float | None) -> dict[Point, list[Cell]]:
    """Return the runs of each point, in order of seed."""
    points = [
        Point(impairment.key, level, model, fallback)
        for impairment in IMPAIRMENTS
        for level in impairment.levels
        for model in MODELS
        for fallback in (True, False)
    ]
    return {
        point: [
            Cell(
                scenario=_SCENARIO,
                seed=seed,
                settings=settings(point),
                duration_s=duration_s or _DURATION_S,
            )
            for seed in range(1, seeds + 1)
        ]
        for point in points
    }


def settings(point: Point) -> tuple[str, ...]:
    """Return the settings by which a point differs from case 15."""
    found = [f"control.schedule.0.model={point.model}"]
    if point.impairment == "loss":
        found.append(f"channel.loss.p={point.level / 100:g}")
    elif point.impairment == "burst":
        leave = 1.0 / point.level  # in Gilbert's model, burst lengths are geometric
        enter = leave * _LOST / (1.0 - _LOST)
        found.append(f"channel.loss.gilbert_elliott={{p: {enter!r}, r: {leave!r}}}")
    else:
        found.append(f"channel.latency={{distribution: fixed, mean_ms: {point.level:g}}}")
    if not point.fallback:
        found.append(f"control.beacon_age_limit_ms={_NEVER_MS:g}")
    return tuple(found)


def degradation(
    study: Study, *, seeds: int, duration_s: float | None, out: Path, command: str
) -> list[Path]:
    """Make the missing runs, then write table, figure and README.md to `out`; return the files.

    The page names `command` as its source. Raises StudyError, ScenarioError or OSError; finished
    runs are kept in the folder of the study.
    """
    cells = plan(seeds, duration_s)
    wanted = sorted((cell for of in cells.values() for cell in of), key=lambda cell: cell.seed)
    digests = study.run(list(dict.fromkeys(wanted)))
    found = {point: [digests[cell] for cell in of] for point, of in cells.items()}
    out.mkdir(parents=True, exist_ok=True)
    return write_whole(out, _files(found, command))


def _files(found: dict[Point, list[Digest]], command: str) -> dict[str, bytes]:
    table = sheet(found)
    end_s = max(float(run.time_s[-1]) for of in found.values() for run in of)
    caption = (
        "Case 15 with other models and worse channels: 40 vehicles on a ring, sensor errors of up "
        "to 10 %, FM until 10 s, when one vehicle brakes for 2 s. Top: the smallest MinDistance in "
        f"the second half of {end_s:g} s. Bottom: the spread of speed over the last 20 s. Solid "
        "lines with circles: vehicles fall back to FM on their radar while the beacons they need "
        "are more than a second old. Dashed lines with crosses: they use beacons of any age. Bars: "
        "95 % confidence intervals over seeds, cut at 0."
    )
    shown = picture(found, caption)
    text = [
        "# Degradation with the channel",
        "",
        f"Written by `{command}` of Zenvoy {version('zenvoy')}.",
        "",
        *in_markdown(shown),
        markdown(table),
    ]
    return {
        **picture_files([shown]),
        f"{table.name}.csv": csv_bytes(table),
        "README.md": "\n".join(text).encode(),
    }
