"""The study, the command and the Python code of docs/sweeps.md run as they are."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Final

import pyarrow.parquet

from tests.conftest import zenvoy
from tests.docs_blocks import blocks
from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.series import SERIES
from zenvoy.studies.sweeps.axes import DISTRIBUTIONS
from zenvoy.studies.sweeps.plan import MOST_RUNS
from zenvoy.studies.sweeps.study_keys import StudyKeys

PAGE: Final = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text()


def block(language: str) -> str:
    return blocks(PAGE, language)[0]


def test_the_page_leads_from_an_empty_file_to_a_picture(tmp_path: Path) -> None:
    (tmp_path / "gains.yaml").write_text(block("yaml"))
    program, *arguments = shlex.split(block("sh"))
    assert program == "zenvoy"
    outcome = zenvoy(tmp_path, *arguments)
    assert (outcome.code, outcome.err) == (0, ""), outcome
    out = tmp_path / "runs" / "gains"
    assert (out / "smallest_gap_m.png").read_bytes().startswith(b"\x89PNG")
    files = set(re.findall(r"^\| `(\w+\.\w+|runs)/?` \|", PAGE, re.MULTILINE))
    assert files - {"series.parquet"} <= {path.name for path in out.iterdir()}
    assert len(files) == 8
    done = subprocess.run(
        [sys.executable, "-c", block("python")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("9 cells × 3 seeds: 27 runs, 0 to do\n")
    assert done.stdout.endswith("\nm\n")
    table = pyarrow.parquet.read_table(out / "table.parquet").to_pylist()
    gaps = {
        gain: [row["smallest_gap_m"] for row in table if row["control.gains.k_v"] == gain]
        for gain in (0.3, 0.9)
    }
    assert sum(gaps[0.9]) > sum(gaps[0.3])  # as the page says


def test_the_page_has_the_message_of_a_bad_study(tmp_path: Path) -> None:
    lines = block("console").splitlines()
    assert lines[0] == "$ zenvoy sweep bad.yaml"
    axis = "channel.loss.p: {from: 0, to: 1, steps: 1000000000}"
    (tmp_path / "bad.yaml").write_text(f"scenario: quickstart\naxes:\n  {axis}\n")
    outcome = zenvoy(tmp_path, "sweep", "bad.yaml")
    assert (outcome.code, outcome.err.splitlines()) == (2, lines[1:])


def test_the_page_has_every_key_distribution_measure_and_series() -> None:
    for key in StudyKeys.model_fields:
        assert f"| `{key}` |" in PAGE, key
    for distribution in DISTRIBUTIONS:
        assert f"{{distribution: {distribution}, " in PAGE
    for name in (*MEASURES, *SERIES):
        first, _, rest = name.partition(".")
        known = f"`{name}`" in PAGE or (f"`{first}` or" in PAGE or f"or `{first}`" in PAGE)
        assert known or first in {"distance_m", "frames"}, (name, rest)
    assert f"at most {MOST_RUNS:,} runs" in PAGE
