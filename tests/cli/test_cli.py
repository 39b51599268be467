"""The `zenvoy` command prints its results, refuses wrong input, and overwrites nothing."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.writer import Writer

from tests.conftest import Outcome, zenvoy
from tests.streamed_log import read_log

TOPICS = (
    "/fleet/truth",
    "/fleet/radar",
    "/fleet/estimate",
    "/fleet/command",
    "/v2v/frames",
    "/events",
    "/clock",
)
SHORT = "{duration_s: 1, fleet: {size: 3}}"


def assert_refused(outcome: Outcome, *texts: str) -> None:
    """Check that there is one line per text on stderr, no other output, and exit code 2."""
    assert outcome.code == 2
    assert outcome.out == ""
    lines = outcome.err.splitlines()
    assert len(lines) == len(texts), outcome.err
    for line, text in zip(lines, texts, strict=True):
        assert text in line


def rows(text: str) -> dict[str, list[str]]:
    """Return the rows of printed tables by their first cell."""
    cells = [line.strip("│┃").replace("┃", "│").split("│") for line in text.splitlines()]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in cells if len(row) > 1}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """Return the folder and the outcome of an in-process run with options that replace values."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "s.yaml").write_text(SHORT)
    options = ["--seed", "7", "--duration-s", "2", "--set", "fleet.size=4", "--set", "seed=6"]
    outcome = zenvoy(folder, "run", "s.yaml", "--bus", "in-process", "--out", "a/b", *options)
    return folder, outcome


def test_a_run_writes_its_log_its_summary_and_its_scenario(done: tuple[Path, Outcome]) -> None:
    folder, outcome = done
    assert (outcome.code, outcome.err) == (0, "")
    left = {path.name for path in (folder / "a" / "b").iterdir()}
    assert left == {"run.mcap", "summary.json", "effective.json", "logs"}
    effective = json.loads((folder / "a" / "b" / "effective.json").read_text())
    assert (effective["seed"], effective["duration_s"], effective["fleet"]["size"]) == (7, 2.0, 4)
    summary = json.loads((folder / "a" / "b" / "summary.json").read_text())
    assert (summary["seed"], summary["cycles"], summary["bus"]) == (7, 20, "in-process")


def test_a_run_prints_its_summary_and_its_folder(done: tuple[Path, Outcome]) -> None:
    folder, outcome = done
    log = read_log(folder / "a" / "b" / "run.mcap")
    printed = rows(outcome.out)
    assert printed["end"] == ["complete"]
    assert printed["fingerprint"] == [log.result["fingerprint"]]
    assert printed["cycles"][0].startswith("20: 2 s simulated in ")
    assert outcome.out.splitlines()[-1] == "written to a/b"


def test_info_prints_the_metadata_of_the_log(done: tuple[Path, Outcome]) -> None:
    folder, _ = done
    outcome = zenvoy(folder, "info", "a/b/run.mcap")
    log = read_log(folder / "a" / "b" / "run.mcap")
    assert (outcome.code, outcome.err) == (0, "")
    printed = rows(outcome.out)
    assert printed["seed"] == ["7"]
    assert printed["vehicles"] == ["4"]
    assert printed["fingerprint"] == [log.result["fingerprint"]]
    counts = {name: cells for name, cells in printed.items() if name.startswith("/")}
    assert counts == {topic: [str(len(log.of(topic)))] for topic in TOPICS}


def test_a_folder_that_is_not_empty_is_refused_and_not_touched(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "run.mcap").write_text("precious")
    refused = zenvoy(tmp_path, "run", "quickstart", "--out", "out", "--bus", "in-process")
    assert_refused(refused, "--out out: is not empty")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["run.mcap"]
    assert (tmp_path / "out" / "run.mcap").read_text() == "precious"


def test_a_file_in_place_of_a_folder_is_refused_and_not_touched(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("precious")
    assert_refused(zenvoy(tmp_path, "run", "quickstart", "--out", "out"), "--out out: ")
    assert (tmp_path / "out").read_text() == "precious"


def test_an_unknown_scenario_is_refused_with_a_suggestion(tmp_path: Path) -> None:
    refused = zenvoy(tmp_path, "run", "quickstrat", "--out", "out")
    assert_refused(refused, "did you mean 'quickstart'?")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("of", ["run", "check", "show"])
def test_all_mistakes_are_printed_at_once(tmp_path: Path, of: str) -> None:
    (tmp_path / "bad.yaml").write_text("fleet: {size: 1}\nchanel: {}\n")
    refused = zenvoy(tmp_path, of, "bad.yaml", "--set", "channel.loss.p=2")
    assert_refused(
        refused,
        "fleet.size: 1 is not in [2, 10000]  (bad.yaml, line 1)",
        "chanel: unknown key; did you mean 'channel'?",
        "channel.loss.p: 2 is not in [0, 1]  (--set channel.loss.p=2)",
    )
    assert {path.name for path in tmp_path.iterdir()} == {"bad.yaml"}


def test_the_output_of_show_is_shown_the_same(tmp_path: Path) -> None:
    options = ["--set", "channel.loss.p=0.25", "--seed", "9", "--duration-s", "3.5"]
    shown = zenvoy(tmp_path, "show", "paper/case-15", *options)
    assert (shown.code, shown.err) == (0, "")
    assert "seed: 9\n" in shown.out
    assert "p: 0.25\n" in shown.out
    (tmp_path / "shown.yaml").write_text(shown.out)
    assert zenvoy(tmp_path, "show", "shown.yaml") == shown


def test_check_prints_that_a_scenario_is_valid(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "check", "quickstart", "--set", "fleet.size=12")
    assert outcome == Outcome(0, "quickstart: valid; 12 vehicles, 60 s\nruns on arrays\n", "")


def test_scenarios_are_listed_with_descriptions(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "scenarios")
    assert (outcome.code, outcome.err) == (0, "")
    listed = dict(line.split(maxsplit=1) for line in outcome.out.splitlines())
    assert listed["quickstart"].startswith("Twenty vehicles on a ring")
    assert "Case 15 of the paper" in listed["paper/case-15"]


def test_technologies_are_printed_beside_those_of_the_package(tmp_path: Path) -> None:
    text = "title: '[red]Mine[/red]'\nrange_m: 200\nbit_rate_mbps: 12\ndelay_ms: 5\n"
    (tmp_path / "mine").write_text(text + "broadcast: true\n")
    outcome = zenvoy(tmp_path, "technologies", "mine", env={"COLUMNS": "200"})
    assert (outcome.code, outcome.err) == (0, "")
    assert "[red]Mine[/red]" in outcome.out
    assert rows(outcome.out)["delay"] == ["10 ms", "10 ms", "20 to 80 ms", "10 ms", "5 ms"]
    (tmp_path / "mine").write_text(text)
    refused = zenvoy(tmp_path, "technologies", "mine")
    assert refused.code == 2
    assert refused.err == "channel.technology.broadcast: missing; allowed: true or false  (mine)\n"


@pytest.mark.parametrize("columns", ["200", "80"])
def test_technologies_have_the_values_of_table_1(tmp_path: Path, columns: str) -> None:
    outcome = zenvoy(tmp_path, "technologies", env={"COLUMNS": columns})
    assert (outcome.code, outcome.err) == (0, "")
    for name in ("ieee80211p", "ieee80211px", "lte-a-pro", "5g-mmwave"):
        assert f"({name})" in outcome.out
    assert "…" not in outcome.out
    if columns == "80":
        return
    printed = rows(outcome.out)
    expected = {
        "band": ["5.85 to 5.925 GHz", "5.85 to 5.925 GHz", "5.72 to 5.75 GHz", "57.05 to 64 GHz"],
        "bandwidth": ["10 MHz", "10 MHz", "≥ 640 MHz", "2.16 GHz"],
        "range": ["1 km", "1 km", "30 km", "50 m"],
        "bit rate": ["3 to 27 Mbit/s", "≥ 60 Mbit/s", "≥ 3 Gbit/s", "≥ 7 Gbit/s"],
        "delay": ["10 ms", "10 ms", "20 to 80 ms", "10 ms"],
        "broadcast": ["yes", "yes", "yes", "no"],
        "V2V": ["yes"] * 4,
        "MIMO": ["yes"] * 4,
    }
    assert {label: printed[label] for label in expected} == expected


def test_info_of_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    assert_refused(zenvoy(tmp_path, "info", "missing.mcap"), "missing.mcap: ")
    (tmp_path / "folder.mcap").mkdir()
    assert_refused(zenvoy(tmp_path, "info", "folder.mcap"), "folder.mcap: ")


@pytest.mark.parametrize(
    "content",
    ["", "hi\n", "a text of more than a few bytes, and of more than one line\n" * 20],
    ids=["empty", "short", "long"],
)
def test_info_of_a_text_file_is_refused_with_a_message(tmp_path: Path, content: str) -> None:
    (tmp_path / "text.mcap").write_text(content)
    refused = zenvoy(tmp_path, "info", "text.mcap")
    assert_refused(refused, "text.mcap: ")
    assert len(refused.err) > len("text.mcap: \n") + 10
    assert "opcode" not in refused.err


def test_info_of_another_log_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "other.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="another")
        writer.add_metadata("another", {"key": "value"})
        writer.finish()
    refused = zenvoy(tmp_path, "info", "other.mcap")
    assert_refused(refused, "other.mcap: an MCAP file, but not the log of a run")


@pytest.fixture
def cut(done: tuple[Path, Outcome], tmp_path: Path) -> Callable[[float], Path]:
    """Return a function that copies a part of the log of the run to cut.mcap."""
    whole = (done[0] / "a" / "b" / "run.mcap").read_bytes()

    def copy(part: float) -> Path:
        (tmp_path / "cut.mcap").write_bytes(whole[: int(part * len(whole))])
        return tmp_path

    return copy


@pytest.mark.parametrize("of", ["info", "analyze"])
def test_a_log_cut_before_its_metadata_is_refused(cut: Callable[[float], Path], of: str) -> None:
    assert_refused(zenvoy(cut(0.01), of, "cut.mcap"), "cut.mcap: cut before the scenario")


@pytest.mark.parametrize("part", [0.5, 0.999])
def test_info_of_a_cut_log_reads_up_to_the_cut(cut: Callable[[float], Path], part: float) -> None:
    outcome = zenvoy(cut(part), "info", "cut.mcap")
    assert outcome.code == 0
    matched = re.fullmatch(
        r"cut\.mcap: the log is cut: read up to ([\d.]+) s of 2 s\n", outcome.err
    )
    assert matched is not None, outcome.err
    printed = rows(outcome.out)
    assert printed["seed"] == ["7"]
    read = read_log(cut(part) / "cut.mcap")
    assert {topic: printed[topic] for topic in TOPICS} == {
        topic: [str(len(read.of(topic)))] for topic in TOPICS
    }
    assert float(matched[1]) == pytest.approx(0.1 * max(0, len(read.of("/fleet/truth")) - 1))


def test_analyze_of_a_cut_log_reads_up_to_the_cut(
    done: tuple[Path, Outcome], cut: Callable[[float], Path]
) -> None:
    whole = zenvoy(done[0], "analyze", "a/b/run.mcap")
    outcome = zenvoy(cut(0.999), "analyze", "cut.mcap")  # all but the end of the index
    assert (outcome.code, whole.code, whole.err) == (0, 0, "")
    assert outcome.err == "cut.mcap: the log is cut: read up to 2 s of 2 s\n"
    assert rows(outcome.out)["frames"] == rows(whole.out)["frames"]
