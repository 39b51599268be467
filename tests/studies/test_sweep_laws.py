"""Sweeps run the user's own laws, beside the scenario or elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from tests.idm import IDM
from zenvoy.studies import sweep
from zenvoy.studies.sweeps.errors import BadStudyError
from zenvoy.studies.sweeps.plan import plan_of
from zenvoy.studies.sweeps.study_file import read_study

SCENARIO: Final = """
extends: quickstart
fleet: {size: 6}
duration_s: 3
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3}]
control: {model: "LAW"}
"""
STUDY: Final = """
scenario: s.yaml
axes: {control.parameters.headway_s: [1.0, 1.6]}
seeds: 2
measures: [smallest_gap_m, speed.estimated.rmse]
"""
REFUSED: Final = "its file is not beside the scenario; --allow-code runs it"


def write(folder: Path, law: str) -> Path:
    """Write a study whose scenario names `law`, and return its path."""
    folder.mkdir()
    (folder / "s.yaml").write_text(SCENARIO.replace("LAW", law))
    (folder / "study.yaml").write_text(STUDY)
    return folder / "study.yaml"


def rows(table: Path) -> list[dict[str, object]]:
    found: list[dict[str, object]] = pyarrow.parquet.read_table(table).to_pylist()
    return found


def test_a_law_beside_the_scenario_gives_the_same_table_on_both_engines(tmp_path: Path) -> None:
    study = write(tmp_path / "study", "idm:smith")
    (tmp_path / "study" / "idm.py").write_text(IDM)
    tables = []
    for engine in ("arrays", "in-process"):
        study.write_text(STUDY + f"engine: {engine}\n")
        outcome = zenvoy(tmp_path, "sweep", str(study), "--out", engine)
        assert (outcome.code, outcome.err) == (0, ""), outcome
        tables.append((tmp_path / engine / "table.parquet").read_bytes())
    assert tables[0] == tables[1]
    gaps = {(row["cell"], row["smallest_gap_m"]) for row in rows(tmp_path / "arrays/table.parquet")}
    assert len({gap for _, gap in gaps}) == 4  # headway and seed both matter


def test_a_changed_source_has_other_keys_and_is_run_again(tmp_path: Path) -> None:
    study = write(tmp_path / "study", "idm:smith")
    law = tmp_path / "study" / "idm.py"
    law.write_text(IDM)
    before = [cell.keys for cell in plan_of(read_study(study)).cells]
    assert zenvoy(tmp_path, "sweep", str(study), "--out", "out").code == 0
    law.write_text(IDM.replace("s0: float = 2.0", "s0: float = 3.0"))
    after = [cell.keys for cell in plan_of(read_study(study)).cells]
    assert not {key for keys in before for key in keys} & {key for keys in after for key in keys}
    first = rows(tmp_path / "out" / "table.parquet")
    outcome = zenvoy(tmp_path, "sweep", str(study), "--out", "out")
    assert outcome.out.startswith("2 cells × 2 seeds: 4 runs, 4 to do\n")
    second = rows(tmp_path / "out" / "table.parquet")
    assert all(
        a["smallest_gap_m"] != b["smallest_gap_m"] for a, b in zip(first, second, strict=True)
    )


def test_a_law_elsewhere_runs_only_if_that_is_allowed(tmp_path: Path) -> None:
    study = write(tmp_path / "study", "../laws/idm.py:smith")
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "idm.py").write_text(IDM)
    refused = zenvoy(tmp_path, "sweep", str(study), "--out", "out")
    assert refused.code == 2
    assert refused.err.count("\n") == 1
    assert REFUSED in refused.err
    assert not (tmp_path / "out").exists()
    allowed = zenvoy(tmp_path, "sweep", str(study), "--out", "out", "--allow-code")
    assert (allowed.code, allowed.err) == (0, ""), allowed
    beside = write(tmp_path / "beside", "idm:smith")
    (tmp_path / "beside" / "idm.py").write_text(IDM)
    assert zenvoy(tmp_path, "sweep", str(beside), "--out", "same").code == 0
    same = (tmp_path / "same" / "table.parquet").read_bytes()
    assert (tmp_path / "out" / "table.parquet").read_bytes() == same
    assert (
        f"`zenvoy sweep {study} --out out --allow-code`"
        in (tmp_path / "out" / "README.md").read_text()
    )


def test_a_law_elsewhere_must_also_be_allowed_from_python(tmp_path: Path) -> None:
    study = write(tmp_path / "study", "../laws/idm.py:smith")
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "idm.py").write_text(IDM)
    with pytest.raises(BadStudyError, match=REFUSED.replace("--allow-code", "allow_code=True")):
        sweep(study, out=tmp_path / "out")
    outcome = zenvoy(tmp_path, "sweep", str(study), "--out", "out", "--allow-code")
    assert outcome.code == 0
    reported: list[str] = []  # nothing is left to run, so no process is forked from this one
    frame = sweep(study, out=tmp_path / "out", on_line=reported.append, allow_code=True)
    assert reported == ["2 cells × 2 seeds: 4 runs, 0 to do"]
    assert len(frame) == 4
