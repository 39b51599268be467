"""`zenvoy compare` compares runs in tables, pictures and words."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import Outcome, zenvoy
from tests.logs import write_log
from tests.pages import Read, read
from zenvoy.analysis.chapters.overview import merits
from zenvoy.analysis.compare.comparison import Compared, _difference, comparison, comparison_page
from zenvoy.analysis.compare.pictures import Labelled, colours, comparison_pictures
from zenvoy.analysis.log.load import load
from zenvoy.analysis.measures.instants import instants_s
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Sheet

BRAKE: Final = "events: [{vehicle: 2, at_s: 2, duration_s: 1, deceleration_mps2: 3}]"
SCENARIOS: Final = {
    "pbcm": f"{{duration_s: 6, seed: 5, fleet: {{size: 6}}, {BRAKE}}}",
    "bcm": f"{{duration_s: 6, seed: 5, fleet: {{size: 6}}, control: {{model: BCM}}, {BRAKE}}}",
    "lossy": f"""{{duration_s: 6, seed: 5, fleet: {{size: 6}}, channel: {{loss: {{p: 0.5}}}},
        {BRAKE}}}""",
    "other": "{duration_s: 4, seed: 6, fleet: {size: 4}, road: {type: open}, period_ms: 50}",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compare")
    for name, scenario in SCENARIOS.items():
        write_log(folder / f"{name}.mcap", scenario)
    write_log(folder / "early.mcap", SCENARIOS["pbcm"], until_cycle=30)
    return folder


def compared(folder: Path, *names: str) -> list[Compared]:
    """Return runs with the names of their scenarios."""
    runs = {name: load(folder / f"{name}.mcap") for name in names}
    return [Compared(label=name, run=run, summary=summary_of(run)) for name, run in runs.items()]


def sheet(of: Sequence[Compared], name: str) -> Sheet:
    """Return a table of a comparison by its name."""
    sheets = [sheet for section in comparison(of) for sheet in section.sheets]
    return next(sheet for sheet in sheets if sheet.name == name)


@pytest.fixture(scope="module")
def outcome(folder: Path) -> Outcome:
    logs = ["pbcm.mcap", "bcm.mcap", "other.mcap"]
    labels = ["--label", "_one", "--label", "<b>$two$</b>", "--label", "three"]
    return zenvoy(folder, "compare", *logs, *labels, "--out", "out", env={"COLUMNS": "80"})


@pytest.fixture(scope="module")
def page(folder: Path, outcome: Outcome) -> Read:
    assert outcome.code == 0, outcome.err
    return read((folder / "out" / "compare.html").read_text())


def test_every_picture_and_table_is_written_in_every_form(folder: Path, page: Read) -> None:
    figures = [f"compare-{name}" for name in ("speeds", "distances", "snapshots", "delays")]
    tables = [f"compare-{name}" for name in ("runs", "settings", "figures")]
    assert page.all("figure", "id") == [f"figure-{name}" for name in figures]
    assert page.all("div", "id") == [f"table-{name}" for name in tables]
    left = {path.name for path in (folder / "out").iterdir()}
    forms = {f"{name}.{form}" for name in figures for form in ("png", "svg")}
    assert left == {"compare.html", *forms, *(f"{name}.csv" for name in tables)}


def test_the_page_is_self_contained(folder: Path, page: Read) -> None:
    html = (folder / "out" / "compare.html").read_text()
    assert page.texts("h1") == ["_one, <b>$two$</b> and three"]
    assert "<b>$two$" not in html
    assert "://" not in html
    assert str(folder) not in html


def test_the_page_begins_with_the_differences_of_runs(outcome: Outcome, page: Read) -> None:
    notes = page.texts("li")
    assert notes == outcome.err.splitlines()
    text = " ".join(notes)
    for difference in (
        "simulated time: _one 6 s, <b>$two$</b> 6 s, three 4 s.",
        "fleet: _one 6 vehicles, <b>$two$</b> 6 vehicles, three 4 vehicles.",
        "road: _one ring, <b>$two$</b> ring, three open.",
        "cycle: _one 100 ms, <b>$two$</b> 100 ms, three 50 ms.",
        "seed: _one 5, <b>$two$</b> 5, three 6.",
    ):
        assert f"The runs differ in their {difference}" in text


def test_the_output_fits_the_width_of_the_terminal(outcome: Outcome) -> None:
    lines = outcome.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert "…" not in outcome.out
    assert lines[0] == "fingerprints: no two are equal"
    assert lines[-1] == "out/compare.html"


def test_the_same_logs_give_the_same_files(folder: Path, page: Read, tmp_path: Path) -> None:
    logs = [str(folder / f"{name}.mcap") for name in ("pbcm", "bcm", "other")]
    labels = ["--label", "_one", "--label", "<b>$two$</b>", "--label", "three"]
    assert zenvoy(tmp_path, "compare", *logs, *labels, "--out", "again").code == 0
    files = [
        {path.name: path.read_bytes() for path in where.iterdir()}
        for where in (folder / "out", tmp_path / "again")
    ]
    assert files[0] == files[1]


def test_differences_equal_those_of_the_summaries(folder: Path) -> None:
    of = compared(folder, "pbcm", "bcm")
    table = sheet(of, "compare-figures")
    assert table.columns == ("figure", "unit", "pbcm", "bcm", "bcm − pbcm")
    first, second = ({m[:2]: m[2] for m in merits(each.summary)} for each in of)
    assert {row[:2] for row in table.rows} == first.keys() | second.keys()
    for name, unit, a, b, difference in table.rows:
        assert (a, b) == (first.get((str(name), str(unit))), second.get((str(name), str(unit))))
        if isinstance(a, int | float) and isinstance(b, int | float):
            assert difference == pytest.approx(b - a, abs=1e-9)
        else:
            assert difference is None  # BCM has no estimates
    assert any(row[4] is None for row in table.rows)


def test_settings_that_differ_are_listed_with_their_keys(folder: Path) -> None:
    of = compared(folder, "pbcm", "bcm", "lossy")
    assert sheet(of, "compare-settings").rows == (
        ("control.model", "PBCM", "BCM", "PBCM"),
        ("channel.loss.p", "0.0", "0.0", "0.5"),
    )
    other = {
        str(row[0]): row[1:]
        for row in sheet(compared(folder, "pbcm", "other"), "compare-settings").rows
    }
    assert other["events.0.at_s"] == ("2.0", "–")
    assert other["events"] == ("–", "none")


def test_equal_runs_are_reported_as_equal(folder: Path) -> None:
    twice = compared(folder, "pbcm")[0]
    again = Compared(label="again", run=twice.run, summary=twice.summary)
    page = comparison_page([twice, again])
    assert page.facts == (("fingerprints", "equal: the logs hold the same data, bit for bit"),)
    assert page.notes == ()
    assert sheet([twice, again], "compare-settings").rows == ()
    assert {row[4] for row in sheet([twice, again], "compare-figures").rows} == {0}
    mixed = comparison_page([twice, *compared(folder, "bcm"), again])
    assert mixed.facts == (("fingerprints", "pbcm = again"),)


def test_a_run_that_ended_early_has_a_note(folder: Path) -> None:
    page = comparison_page(compared(folder, "pbcm", "early"))
    assert "early: The run was interrupted at 3 s of 6 s." in page.notes


def labelled(folder: Path, *names: str) -> list[Labelled]:
    return [Labelled(name, load(folder / f"{name}.mcap")) for name in names]


def test_models_that_differ_have_their_colours(folder: Path) -> None:
    by_model = [style.MODEL_COLOURS["PBCM"], style.MODEL_COLOURS["BCM"]]
    assert colours(labelled(folder, "pbcm", "bcm")) == by_model
    assert colours(labelled(folder, "pbcm", "lossy")) == list(style.CYCLE[:2])
    assert len(colours(labelled(folder, *["pbcm"] * 9))) == 9


def test_heat_maps_share_one_scale_and_distances_one_axis(folder: Path) -> None:
    runs = labelled(folder, "pbcm", "bcm", "other", "lossy")
    speeds, distances, *_ = comparison_pictures(runs)
    images = [axes.images[0] for axes in speeds.draw().axes if axes.images]
    low = min(run.truth["speed"].min() for _, run in runs)
    high = max(run.truth["speed"].max() for _, run in runs)
    assert [image.get_clim() for image in images] == [(low, high)] * 4
    assert {axes.get_xlim() for axes in distances.draw().axes} == {(0.0, 6.0)}
    drawn = [[line.get_color() for line in axes.lines] for axes in distances.draw().axes]
    assert drawn == [list(style.CYCLE[:4])] * 2


def test_snapshots_are_at_times_that_all_runs_have(folder: Path) -> None:
    assert instants_s([run for _, run in labelled(folder, "pbcm", "bcm")]) == [2, 3, 4]
    assert instants_s([run for _, run in labelled(folder, "other", "other")]) == [0, 1, 2]
    *_, snapshots, delays = comparison_pictures(labelled(folder, "pbcm", "other"))
    assert [axes.get_title("left") for axes in snapshots.draw().axes] == ["2 s", "3 s", "4 s"]
    assert [len(axes.lines) for axes in delays.draw().axes] == [2, 2]


def test_a_file_that_is_no_log_is_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "text.mcap").write_text("hi\n")
    log = str(folder / "pbcm.mcap")
    outcome = zenvoy(tmp_path, "compare", log, "text.mcap", "--out", "out")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("text.mcap: ")
    assert len(outcome.err.splitlines()) == 1
    assert not (tmp_path / "out").exists()
    refused = zenvoy(tmp_path, "compare", log, "--out", "out")
    assert (refused.code, refused.err) == (
        2,
        f"{log}: only one run; name two or more to compare\n",
    )


def test_rounding_is_no_difference() -> None:
    assert _difference(10.4, 10.400000000000004) == 0.0
    assert _difference(10.5, 10.4) == pytest.approx(0.1)
    assert _difference(3, 3) == 0
    assert _difference(1e-15, 0.0) == 1e-15
    assert _difference(None, 1.0) is None
