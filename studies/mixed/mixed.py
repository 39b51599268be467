"""Mixed traffic: makes the missing runs of all its studies, then the tables, pictures and page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.section import Picture, Sheet
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.scenarios import load
from zenvoy.studies.mixed import penetration, pictures, ring
from zenvoy.studies.sweeps.errors import bad_study
from zenvoy.studies.sweeps.running import runs_of
from zenvoy.studies.sweeps.study_file import read_study
from zenvoy.studies.sweeps.sweep import Made, OnLine, make_runs


def run_mixed(
    *,
    seeds: int,
    duration_s: float | None,
    out: Path,
    runs: Path,
    jobs: int | None,
    on_line: OnLine,
    command: str,
) -> list[Path]:
    """Make the missing runs in `runs`, then write tables, pictures and README.md to `out`.

    The folder `out` exists, and `require_control` accepts `duration_s`. Returns the files. The page
    names `command` as its source. A run that fails is reported on a line, and left out. Raises
    BadStudyError or OSError; finished runs are kept.
    """

    def made(study: Mapping[str, object], name: str) -> Made:
        return make_runs(read_study(study), out=runs / name, jobs=jobs, on_line=on_line)

    on_ring = made(ring.study(seeds, duration_s), "ring")
    points: dict[penetration.Line, list[penetration.Point]] = {}
    for name in penetration.SCENARIOS:
        found = made(penetration.study(name, seeds, duration_s), name.replace("/", "-"))
        points |= penetration.lines(name, found, _duration_s(name, duration_s))
    spans = ring.spans(_duration_s(ring.HUMANS, duration_s))
    driven, control_s = ring.driven(on_ring, spans), spans.before.until_s
    drawn = [
        pictures.speeds(dict(_shown(duration_s)), control_s),
        pictures.spread(driven, control_s),
        pictures.penetration(points),
    ]
    return write_whole(out, _files(drawn, [ring.sheet(driven), penetration.sheet(points)], command))


def require_control(duration_s: float | None) -> None:
    """Raise BadStudyError if runs end before a car is controlled."""
    control_s = ring.spans(0.0).before.until_s
    if duration_s is not None and duration_s <= control_s:
        text = f"{duration_s:g} s: a car is controlled from {control_s:g} s on; allowed: more"
        raise bad_study("", f"--duration-s {text}")


def _duration_s(name: str, given_s: float | None) -> float:
    return load(name).scenario.duration_s if given_s is None else given_s


def _shown(duration_s: float | None) -> Iterator[tuple[str, Run]]:
    """Yield a run of each variant of the ring with the first seed."""
    for car, name in {ring.NOBODY: ring.HUMANS, **ring.CONTROLLED}.items():
        (run,) = runs_of([load(name, duration_s=duration_s)], "arrays")
        yield car, run


def _files(drawn: list[Picture], sheets: list[Sheet], command: str) -> dict[str, bytes]:
    text = [
        "# Mixed traffic: all figures",
        "",
        f"Written by `{command}` of Zenvoy {version('zenvoy')}.",
        "[Mixed traffic](../mixed-traffic.md) explains them.",
        "",
    ]
    for picture in drawn:
        text += in_markdown(picture)
    text += [markdown(sheet) for sheet in sheets]
    tables = {f"{sheet.name}.csv": csv_bytes(sheet) for sheet in sheets}
    return {**picture_files(drawn), **tables, "README.md": "\n".join(text).encode()}
