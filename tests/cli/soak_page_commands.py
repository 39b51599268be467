"""Every command in the documentation does what it says; `make soak` runs them, in minutes."""

from __future__ import annotations

import gzip
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pytest

from tests.cli.pages import ELSEWHERE, FOLLOWED, NOT_RUN, PAGES, ROOT, begins_as
from tests.conftest import LIMIT_S, Outcome, command, wait_until, zenvoy
from tests.page_commands import commands_of_blocks, shortened
from tests.recorded_convoys import long_text, openacc_text, platoon

MOST_S: Final = 5 * LIMIT_S
UNTIL_STOPPED: Final = ("view", "--view", "--foxglove", "--without")
MISTAKES: Final = """description: Two mistakes
extends: paper/case-15
duration_s: 100
channel:
  technology: lte-a-pro
  los: {p: 0.1}
events:
  # nobody has this number
  - {type: brake, vehicle: 50, at_s: 20, duration_s: 2, deceleration_mps2: 3}
"""
SATELLITE: Final = (
    "title: A low orbit\nrange_m: 100000\nbit_rate_mbps: 50\ndelay_ms: [25, 60]\nbroadcast: true\n"
)


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all files that readers have before they type the commands of a page."""
    folder = tmp_path_factory.mktemp("reader")
    text = openacc_text(platoon(20.0))
    for name in ("drive.csv.gz", "run.csv.gz", "another.csv.gz"):
        (folder / name).write_bytes(gzip.compress(text.encode(), mtime=0))
    (folder / "drive.csv").write_text("time_s,speed_mps\n0,30\n10,30\n14.5,24\n")
    (folder / "fcd.csv").write_text(fcd_text())
    (folder / "mine.yaml").write_text(MISTAKES)
    (folder / "satellite.yaml").write_text(SATELLITE)
    (folder / "docs").mkdir()
    for study in ROOT.glob("docs/*.yaml"):
        short = re.sub(r"^seeds: \d+", "seeds: 1", study.read_text("utf-8"), flags=re.MULTILINE)
        short = re.sub(r"^duration_s: \d+", "duration_s: 1", short, flags=re.MULTILINE)
        (folder / "docs" / study.name).write_text(short, "utf-8")
    for name in ("demo", "a", "b"):
        out = ("--out", f"runs/{name}", "--duration-s", "2")
        assert zenvoy(folder, "run", "quickstart", "--engine", "arrays", *out).code == 0
    log = (folder / "runs/demo/run.mcap").read_bytes()
    (folder / "cut.mcap").write_bytes(log[: 9 * len(log) // 10])
    return folder


def fcd_text() -> str:
    """Return a table with the columns of SUMO's floating car data as CSV."""
    _, _, rows = long_text(platoon(20.0)).partition("\n")
    return f"timestep_time,vehicle_id,vehicle_pos,vehicle_speed\n{rows}"


def gaps_text() -> str:
    """Return a table with a column of speeds and one of gaps for each car, but the first's gap."""
    found = platoon(20.0)
    cars = range(1, found.speed.shape[1] + 1)
    rows = [["t_ms", *(f"v_{car} [km/h]" for car in cars), *(f"gap_{car}" for car in cars[1:])]]
    for time_s, speed, gap in zip(*found, strict=True):
        cells = [1000 * time_s, *(3.6 * speed), *gap[1:]]
        rows.append([f"{cell:.5f}" for cell in cells])
    return "\n".join(",".join(row) for row in rows) + "\n"


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page.name not in FOLLOWED],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_commands_of_a_page_work(page: Path, prepared: Path, tmp_path: Path) -> None:
    shutil.copytree(prepared, tmp_path, dirs_exist_ok=True)
    if page.name == "convoys.md":
        (tmp_path / "drive.csv").write_text(gaps_text())
    for typed in commands_of_blocks(page.read_text("utf-8")):
        if begins_as(typed, {*ELSEWHERE, *NOT_RUN}):
            continue
        words = shortened(typed.words)
        if words[:2] == ["zenvoy", "certs"]:  # of another way to do the same
            shutil.rmtree(tmp_path / "keys", ignore_errors=True)
        if words[0] == "python":
            subprocess.run([sys.executable, *words[1:]], cwd=ROOT, check=True, timeout=MOST_S)
        elif set(words) & set(UNTIL_STOPPED):
            run_until_stopped(tmp_path, words)
        else:
            outcome = run_to_its_end(tmp_path, words)
            expected = (2, [*typed.shown]) if typed.shown else (0, outcome.err.splitlines())
            assert (outcome.code, outcome.err.splitlines()) == expected, (words, outcome)


def run_to_its_end(folder: Path, words: Sequence[str]) -> Outcome:
    """Run a command, with its output into a file if it says so."""
    end = words.index(">") if ">" in words else len(words)
    with command(folder, *globbed(folder, words[1:end])) as started:
        outcome = started.wait(MOST_S)
    for file in words[end + 1 :]:
        (folder / file).write_text(outcome.out, "utf-8")
    return outcome


def run_until_stopped(folder: Path, words: Sequence[str]) -> None:
    """Run a command that goes on until Ctrl-C."""
    with command(folder, *words[1:]) as started:
        wait_until(
            lambda: bool(re.search("shown at|to join it|ws://", started.out)), " ".join(words)
        )
        started.send_to_group(signal.SIGINT)
        outcome = started.wait()
    assert outcome.code in (0, 130), (words, outcome)


def globbed(folder: Path, words: Sequence[str]) -> list[str]:
    """Return the words with files in place of patterns, as a shell does."""
    found: list[str] = []
    for word in words:
        files = sorted(path.name for path in folder.glob(word)) if word.startswith("*.") else []
        found += files or [word]
    return found
