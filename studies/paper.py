"""The paper's evaluation: its runs, and the tables, figures and claims that result."""

from __future__ import annotations

from collections.abc import Iterator, Sized
from importlib.metadata import version
from pathlib import Path
from typing import Final

from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.paper.evidence import MODELS, Evidence
from zenvoy.analysis.paper.gains import GAINS
from zenvoy.analysis.paper.reproduction import claims_page, markdown, pictures, sheets
from zenvoy.studies.cell import Cell
from zenvoy.studies.study import Study

_CASES: Final = tuple(f"{number:02}" for number in range(1, 17))
_FINGERPRINTS: Final = "fingerprints.csv"
_FEW_SEEDS: Final = 5  # the open road and old positions supplement the ring, with fewer seeds
_CONTROLLED: Final = {"FM": "03", "BCM": "07", "MBCM": "11", "PBCM": "15"}  # 10 %, 0.1 s
_OLD: Final = ("control.neighbour_state=position", "control.v2v_wait_ms=0")
_EQUAL_GAINS: Final = ("control.gains.k_c=0.1", "control.gains.k_d=0.1")


def plan(seeds: int, duration_s: float | None) -> dict[str, list[Cell]]:
    """Return the runs under each label of the results; supplementary runs have fewer seeds."""
    cells = {number: _cells(number, seeds, (), duration_s) for number in _CASES}
    few = max(min(seeds, _FEW_SEEDS), seeds // 10)
    for number in _CASES:
        cells[f"open/{number}"] = _cells(number, few, ("road.type=open",), duration_s)
    cells |= dict(_old_positions(few, duration_s))
    cells["sign/BCM"] = _cells("07", few, ("control.gains.k_c=-0.05",), duration_s)
    short_s = 120.0 if duration_s is None else duration_s
    for gains in GAINS:
        settings = tuple(
            f"control.gains.{name}={value:g}" for name, value in gains._asdict().items()
        )
        for model in MODELS:
            cells[gains.label(model)] = _cells(
                _CONTROLLED[model], max(1, seeds // 10), settings, short_s
            )
    return cells


def _cells(
    number: str, seeds: int, settings: tuple[str, ...], duration_s: float | None
) -> list[Cell]:
    return [
        Cell(scenario=f"paper/case-{number}", seed=seed, settings=settings, duration_s=duration_s)
        for seed in range(1, seeds + 1)
    ]


def _old_positions(seeds: int, duration_s: float | None) -> Iterator[tuple[str, list[Cell]]]:
    """Yield runs whose reported positions are one period old: 0.1 s or a third of a second."""
    span_s = 200.0 if duration_s is None else duration_s
    ages = {"0.1 s": (), "1/3 s": ("period_ms=333.333333",)}
    for model in ("BCM", "MBCM"):
        for age, period in ages.items():
            settings = (*_OLD, *_EQUAL_GAINS, *period)
            label = f"stale/{model}, positions {age} old, k_c = k_d"
            yield label, _cells(_CONTROLLED[model], seeds, settings, span_s)


def reproduce(
    study: Study, *, seeds: int, duration_s: float | None, out: Path, command: str
) -> list[Path]:
    """Make the missing runs, then write all results to `out`; return the files.

    The pages name `command` as their source. Raises StudyError, ScenarioError or OSError; finished
    runs are kept in the folder of the study.
    """
    cells = plan(seeds, duration_s)
    # Run seed by seed, so that an interrupted study has every case for some seeds.
    wanted = sorted((cell for of_label in cells.values() for cell in of_label), key=_by_seed)
    digests = study.run(list(dict.fromkeys(wanted)))
    evidence = Evidence(
        runs={label: tuple(digests[cell] for cell in of_label) for label, of_label in cells.items()}
    )
    out.mkdir(parents=True, exist_ok=True)
    made = sum(bool(run.facts["fingerprint"]) for run in digests.values())
    earlier = _rows(out / _FINGERPRINTS)
    files = _files(evidence, command, len(digests), _about_fingerprints(made, earlier, digests))
    if earlier > made:
        files.pop(_FINGERPRINTS, None)
    return write_whole(out, files)


def _rows(sheet: Path) -> int:
    """Return how many rows a CSV file has below its header."""
    try:
        return max(0, sheet.read_bytes().count(b"\n") - 1)
    except OSError:
        return 0


def _about_fingerprints(made: int, earlier: int, digests: Sized) -> str:
    """Return what the sheet of fingerprints holds: the longer one of an earlier run is kept."""
    if earlier > made:
        return f" `{_FINGERPRINTS}` holds the fingerprints of earlier runs."
    if not made:
        return ""
    of = "every run" if made == len(digests) else f"{made} of them"
    return f" `{_FINGERPRINTS}` lists the fingerprint of {of}."


def _by_seed(cell: Cell) -> tuple[int, bool]:
    return cell.seed, bool(cell.settings)


def _files(evidence: Evidence, command: str, runs: int, more: str) -> dict[str, bytes]:
    found = [sheet for sheet in sheets(evidence) if sheet.rows]
    shown = pictures(evidence)
    files = {f"{sheet.name}.csv": csv_bytes(sheet) for sheet in found} | picture_files(shown)
    how = [
        f"Written by `{command}` of Zenvoy {version('zenvoy')}: {runs:,} runs. Values are"
        " means over the seeds 1, 2, … with their 95 % confidence intervals (Student's t)."
        f"{more}",
    ]
    readme = ["# Reproduction of the paper's evaluation", "", *how, ""]
    readme += ["[Claims](claims.md) compares each claim of the paper with the measurements.", ""]
    for picture in shown:
        readme += in_markdown(picture)
    readme += [markdown(sheet) for sheet in found if sheet.name != "fingerprints"]
    files["README.md"] = "\n".join(readme).encode()
    files["claims.md"] = claims_page(evidence, how).encode()
    return files
