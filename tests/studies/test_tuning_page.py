"""The study, the commands and the Python code of docs/tuning.md run as they are."""

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
from zenvoy.studies.tuning.keys import MOST_TRIALS, Sampler, TuneKeys

PAGE: Final = (Path(__file__).parents[2] / "docs" / "tuning.md").read_text()


def test_from_an_empty_file_to_a_picture(tmp_path: Path) -> None:
    (tmp_path / "stable.yaml").write_text(blocks(PAGE, "yaml")[0])
    for block in blocks(PAGE, "sh"):
        program, *arguments = shlex.split(block)
        assert program == "zenvoy"
        outcome = zenvoy(tmp_path, *arguments)
        assert (outcome.code, outcome.err) == (0, ""), outcome
    out = tmp_path / "runs" / "stable"
    for name in ("search.png", "parameters.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    files = set(re.findall(r"^\| `(\w+\.\w+|runs)/?` \|", PAGE, re.MULTILINE))
    assert files <= {path.name for path in out.iterdir()}
    assert len(files) == 10
    done = subprocess.run(
        [sys.executable, "-c", blocks(PAGE, "python")[0]],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "30 trials × 2 seeds, 0 to do"
    rows = pyarrow.parquet.read_table(out / "trials.parquet").to_pylist()
    feasible = [row for row in rows if row["feasible"]]
    best = min(feasible, key=lambda row: float(row["gap.measured.spread"]))
    assert lines[-1] == str(best["trial"])
    # As the page says:
    stiff = [row for row in rows if row["control.gains.k_d"] > 0.1]
    assert sum(row["head_to_tail_gain"] > 1.0 for row in stiff) > len(stiff) / 2
    soft = min(feasible, key=lambda row: float(row["control.gains.k_d"]))
    assert best["gap.measured.spread"] < soft["gap.measured.spread"]


def test_the_line_of_a_bad_study(tmp_path: Path) -> None:
    lines = blocks(PAGE, "console")[0].splitlines()
    assert lines[0] == "$ zenvoy tune bad.yaml"
    parameter = "control.gains.k_v: {low: 2, high: 1}"
    (tmp_path / "bad.yaml").write_text(
        f"scenario: quickstart\nparameters:\n  {parameter}\nminimize: collisions\n"
    )
    outcome = zenvoy(tmp_path, "tune", "bad.yaml")
    assert (outcome.code, outcome.err.splitlines()) == (2, lines[1:])


def keys_in(table: str) -> set[str]:
    """Return the keys in the first column of a table that begins the text."""
    rows = table.partition("\n\n")[0].splitlines()
    return set(re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in rows)))


def test_the_page_has_every_key() -> None:
    of_study, of_sampler = re.split(r"^\| key .*\n", PAGE, flags=re.MULTILINE)[1:]
    assert keys_in(of_study) == set(TuneKeys.model_fields)
    assert keys_in(of_sampler) == set(Sampler.model_fields)
    assert f"at most {MOST_TRIALS:,}" in PAGE
