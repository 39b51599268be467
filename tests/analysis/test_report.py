"""`zenvoy analyze` writes the report, tables and pictures, and prints a summary."""

from __future__ import annotations

import csv
import re
import resource
import shutil
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import pytest
from mcap.reader import make_reader

from tests.conftest import Outcome, zenvoy
from tests.logs import write_log
from tests.pages import Read, read
from zenvoy.analysis.chapters.overview import merits
from zenvoy.analysis.log.load import load
from zenvoy.analysis.measures.summary import summarize
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.report import models, report_page
from zenvoy.scenarios import Scenario
from zenvoy.scenarios import load as load_scenario

EVIL: Final = "<script>alert(1)</script> & $x"
SCENARIO: Final = f"""
description: "{EVIL}"
duration_s: 12
seed: 5
fleet: {{size: 6, gap_m: 20}}
control: {{model: FM, desired_gap_m: 20, schedule: [{{at_s: 2, model: PBCM}}]}}
channel: {{loss: {{p: 0.2}}}}
events:
  - {{vehicle: 2, at_s: 4, duration_s: 1, deceleration_mps2: 3}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a log with a very odd name."""
    folder = tmp_path_factory.mktemp("report")
    write_log(folder / "_a$b$.mcap", SCENARIO)
    return folder


@pytest.fixture(scope="module")
def outcome(folder: Path) -> Outcome:
    """Return the outcome of its analysis on a narrow terminal."""
    return zenvoy(folder, "analyze", "_a$b$.mcap", env={"COLUMNS": "80"})


@pytest.fixture(scope="module")
def left(folder: Path, outcome: Outcome) -> dict[str, bytes]:
    """Return the files of the analysis by name."""
    assert (outcome.code, outcome.err) == (0, "")
    return {path.name: path.read_bytes() for path in (folder / "_a$b$-analysis").iterdir()}


@pytest.fixture(scope="module")
def page(left: dict[str, bytes]) -> Read:
    return read(left["report.html"].decode())


def test_the_chapters_come_in_their_order(page: Read) -> None:
    chapters = ["Overview", "Motion", "String stability", "Estimation", "V2V"]
    assert page.texts("a") == chapters
    assert page.texts("h2") == ["Contents", *chapters]


def test_every_picture_and_table_is_written_in_every_form(
    left: dict[str, bytes], page: Read
) -> None:
    figures = {name.removeprefix("figure-") for name in page.all("figure", "id")}
    tables = {name.removeprefix("table-") for name in page.all("div", "id")}
    assert {"overview"} <= figures
    assert {"summary"} <= tables
    forms = {f"{name}.{form}" for name in figures for form in ("png", "svg")}
    assert left.keys() == {"report.html", *forms, *(f"{name}.csv" for name in tables)}
    for name in figures:
        assert left[f"{name}.png"].startswith(b"\x89PNG")
        root = ElementTree.fromstring(left[f"{name}.svg"])
        assert root.tag.endswith("svg")


def test_the_summary_equals_that_of_the_log(folder: Path, left: dict[str, bytes]) -> None:
    rows = list(csv.reader(left["summary.csv"].decode().splitlines()))
    assert rows[0] == ["figure", "unit", "value"]
    expected = merits(summarize(folder / "_a$b$.mcap"))
    assert [(name, unit) for name, unit, _ in rows[1:]] == [merit[:2] for merit in expected]
    assert [float(row[2]) for row in rows[1:]] == [merit[2] for merit in expected]
    assert {"smallest gap", "MinDistance, dip", "RMSE of the estimated gap"} <= {r[0] for r in rows}


def test_the_report_describes_the_run(page: Read, folder: Path) -> None:
    run = load(folder / "_a$b$.mcap")
    assert page.texts("h1") == ["_a$b$, seed 5"]
    facts = dict(zip(page.texts("dt"), page.texts("dd"), strict=True))
    assert facts["vehicles"] == "6, on a ring of 120 m"
    assert facts["model"] == "FM, PBCM from 2 s"
    assert facts["duration"] == "12 s, in cycles of 100 ms"
    assert facts["how it ended"] == "complete"
    assert facts["fingerprint"] == run.result["fingerprint"]
    assert f"zenvoy {run.run['version.zenvoy']}" in facts["versions"]
    assert "zenvoy analyze _a$b$.mcap" in page.texts("p")[-1]


def test_the_scenario_on_the_page_is_that_of_the_run(
    page: Read, folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "again.yaml").write_text("".join(page.text["pre"]))
    again = load_scenario(tmp_path / "again.yaml")
    assert again.scenario == load(folder / "_a$b$.mcap").scenario


def test_the_report_is_self_contained_and_discloses_nothing(
    left: dict[str, bytes], page: Read, folder: Path
) -> None:
    """It has no script from a description, no address, and no path of this machine."""
    html = left["report.html"].decode()
    assert EVIL in page.texts("p")
    assert "<script" not in html
    assert "://" not in html
    assert str(folder) not in html
    assert len(html) < 5_000_000


def test_the_same_log_gives_the_same_files(
    folder: Path, left: dict[str, bytes], tmp_path: Path
) -> None:
    """This holds in another folder, and from another working directory."""
    (tmp_path / "logs").mkdir()
    shutil.copy(folder / "_a$b$.mcap", tmp_path / "logs" / "_a$b$.mcap")
    again = zenvoy(tmp_path, "analyze", "logs/_a$b$.mcap", "--out", "elsewhere")
    assert again.code == 0
    assert {path.name: path.read_bytes() for path in (tmp_path / "elsewhere").iterdir()} == left


def test_the_output_fits_the_width_of_the_terminal(outcome: Outcome) -> None:
    lines = outcome.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert "…" not in outcome.out
    assert "_a$b$, seed 5" in outcome.out
    assert lines[-1] == "_a$b$-analysis/report.html"
    assert "_a$b$-analysis/overview.{png,svg}" in lines


@pytest.mark.parametrize(
    ("lost", "message"),
    [
        ("", "the run was interrupted at 5 s of 12 s"),
        ("vehicle-03", "process vehicle-03 was lost at 5 s"),
    ],
)
def test_the_report_of_a_run_that_ended_early_begins_with_a_note(
    tmp_path: Path, lost: str, message: str
) -> None:
    write_log(tmp_path / "run.mcap", SCENARIO, until_cycle=50, lost=lost)
    outcome = zenvoy(tmp_path, "analyze", "run.mcap")
    assert outcome.code == 0
    assert message in outcome.err
    html = (tmp_path / "run-analysis" / "report.html").read_text()
    notes = read(html).texts("li")
    assert any(message.lower() in note.lower() for note in notes)
    assert html.index("Read this first") < html.index("fingerprint")


def test_a_cut_log_is_analysed_up_to_the_cut(tmp_path: Path) -> None:
    whole = write_log(tmp_path / "run.mcap", "{duration_s: 6}").read_bytes()  # several chunks
    (tmp_path / "run.mcap").write_bytes(whole[: int(0.7 * len(whole))])
    outcome = zenvoy(tmp_path, "analyze", "run.mcap")
    assert outcome.code == 0
    matched = re.fullmatch(
        r"run\.mcap: the log is cut: read up to ([\d.]+) s of 6 s\n", outcome.err
    )
    assert matched is not None, outcome.err
    assert 1.0 < float(matched[1]) < 6.0
    page = read((tmp_path / "run-analysis" / "report.html").read_text())
    assert page.texts("li") == [f"The log is cut: read up to {matched[1]} s of 6 s."]
    facts = dict(zip(page.texts("dt"), page.texts("dd"), strict=True))
    assert facts["fingerprint"] == facts["how it ended"] == "not logged"
    assert facts["duration"] == f"{matched[1]} s of 6 s, in cycles of 100 ms"


def test_a_log_cut_before_its_first_cycle_is_refused(folder: Path, tmp_path: Path) -> None:
    with (folder / "_a$b$.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None
        file.seek(0)
        cut = file.read(summary.chunk_indexes[0].chunk_start_offset + 100)
    (tmp_path / "run.mcap").write_bytes(cut)
    message = "the log is cut: read up to 0 s of 12 s; no cycle was logged"
    refused = Outcome(2, "", f"run.mcap: nothing to show: {message}\n")
    assert zenvoy(tmp_path, "analyze", "run.mcap") == refused
    assert {path.name for path in tmp_path.iterdir()} == {"run.mcap"}


@pytest.mark.parametrize("of", ["analyze", "compare"])
def test_a_run_without_a_cycle_is_refused(folder: Path, tmp_path: Path, of: str) -> None:
    write_log(tmp_path / "run.mcap", SCENARIO, until_cycle=0)
    logs = ["run.mcap"] if of == "analyze" else [str(folder / "_a$b$.mcap"), "run.mcap"]
    outcome = zenvoy(tmp_path, of, *logs, "--out", "out")
    message = "the run was interrupted at 0 s of 12 s; no cycle was logged"
    assert outcome == Outcome(2, "", f"run.mcap: nothing to show: {message}\n")
    assert not (tmp_path / "out").exists()


def test_a_run_of_two_cycles_is_analysed(tmp_path: Path) -> None:
    write_log(tmp_path / "run.mcap", SCENARIO, until_cycle=2)
    outcome = zenvoy(tmp_path, "analyze", "run.mcap")
    assert outcome.code == 0, outcome.err
    read((tmp_path / "run-analysis" / "report.html").read_text())


def test_a_full_disk_leaves_no_half_file(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    log = str(folder / "_a$b$.mcap")
    limit = (resource.RLIMIT_FSIZE, 50_000)
    outcome = zenvoy(tmp_path, "analyze", log, "--out", "out", limit=limit)
    assert outcome.code == 1
    assert outcome.err == "out: cannot write: File too large\n"
    assert list((tmp_path / "out").iterdir()) == []


def test_a_file_in_place_of_the_folder_is_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("precious")
    outcome = zenvoy(tmp_path, "analyze", str(folder / "_a$b$.mcap"), "--out", "out")
    assert outcome == Outcome(2, "", "--out out: File exists\n")
    assert (tmp_path / "out").read_text() == "precious"


def test_models_are_named_with_their_times_and_numbers() -> None:
    def named(text: str) -> str:
        return models(Scenario.model_validate_json(text))

    assert named("{}") == "PBCM"
    switch = '"schedule": [{"at_s": 10, "model": "FM"}, {"at_s": 20, "model": "BCM"}]'
    assert named(f'{{"control": {{"model": "FM", {switch}}}}}') == "FM, BCM from 20 s"
    group = '"groups": [{"name": "new", "vehicles": "1, 4", "model": "CACC"}]'
    assert named(f'{{"fleet": {{"size": 6, {group}}}}}') == "PBCM (4 vehicles); CACC (2 vehicles)"


def test_notes_become_sentences(folder: Path) -> None:
    run = load(folder / "_a$b$.mcap")
    page = report_page(run, ())
    assert isinstance(page, Page)
    assert page.notes == ()
    assert page.lead == EVIL
