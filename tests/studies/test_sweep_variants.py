"""An axis may have names as values, each of which stands for any number of settings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from tests.studies.conftest import write_study
from zenvoy.studies.sweeps.plan import plan_of
from zenvoy.studies.sweeps.study_file import read_study

STUDY = """
scenario: quickstart
settings: {fleet.size: 6, "events.0.at_s": 1}
duration_s: 3
axes:
  radio:
    variants:
      plain: {}
      lossy: {channel.loss.p: 0.5, channel.technology: lte-a-pro}
  control.gains.k_v: [0.3, 0.5]
seeds: 2
measures: [smallest_gap_m]
"""


def test_a_variant_changes_its_settings_and_no_others(tmp_path: Path) -> None:
    plan = plan_of(read_study(write_study(tmp_path, STUDY)))
    channels = [plan.cell(cell, 1).load().scenario.channel for cell in plan.cells]
    assert [(one.loss.p, one.technology.name) for one in channels] == [
        (0.05, "ieee80211p"),
        (0.05, "ieee80211p"),
        (0.5, "lte-a-pro"),
        (0.5, "lte-a-pro"),
    ]
    assert [str(cell) for cell in plan.cells][2] == 'radio="lossy" control.gains.k_v=0.3'


def test_a_table_has_the_names_of_variants(tmp_path: Path) -> None:
    write_study(tmp_path, STUDY)
    outcome = zenvoy(tmp_path, "sweep", "study.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    rows = pyarrow.parquet.read_table(tmp_path / "out" / "table.parquet").to_pylist()
    assert [row["radio"] for row in rows] == ["plain"] * 4 + ["lossy"] * 4
    alone = {(row["control.gains.k_v"], row["seed"]): row["smallest_gap_m"] for row in rows[:4]}
    (tmp_path / "plain.yaml").write_text(
        STUDY.replace("  radio:\n    variants:\n      plain: {}\n", "").replace(
            "      lossy: {channel.loss.p: 0.5, channel.technology: lte-a-pro}\n", ""
        )
    )
    outcome = zenvoy(tmp_path, "sweep", "plain.yaml", "--out", "same")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    rows = pyarrow.parquet.read_table(tmp_path / "same" / "table.parquet").to_pylist()
    assert {(r["control.gains.k_v"], r["seed"]): r["smallest_gap_m"] for r in rows} == alone


AXES = "scenario: quickstart\naxes:\n"
BAD = {
    AXES + "  radio:\n    variants:\n      a: {channel.los.p: 0.1}\n": "channel.los: unknown key; "
    "did you mean 'loss'?",
    AXES + "  radio: {variants: {}}\n": "axes.radio.variants: a mapping is not a mapping of names",
    AXES + "  radio: {variants: {a: 3}}\n": "axes.radio.variants.a: 3 is not a mapping of names to "
    "mappings of settings  (study.yaml, line 3)",
    AXES + "  radio:\n    variants:\n      a: {seed: 3}\n": "axes.radio.variants.a.seed: is no "
    "axis; use the key seeds of the study  (study.yaml, line 5)",
    AXES + "  cell: {variants: {a: {}}}\n": "axes.cell: is the name of another column of the "
    "table; allowed: any other name  (study.yaml, line 3)",
    AXES + "  channel.loss.p: [0, 1]\n  radio:\n    variants: {a: {channel.loss.p: 0.1}}\n": "axes."
    "radio: channel.loss.p is varied by the axis channel.loss.p too  (study.yaml, line 4)",
    AXES + "  radio:\n    variants: {a: {channel.loss.p: 0.1}}\nsettings: [channel.loss.p=0.2]\n": (
        "settings: channel.loss.p is an axis of the study too  (study.yaml, line 5)"
    ),
    AXES + "  radio:\n    variants: {a: {channel.loss.p: 1.4}}\n": "channel.loss.p: 1.4 is not in "
    "[0, 1]  (study.yaml, line 3)",
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_bad_variants_are_refused_in_one_line(
    refusal_of_study: Callable[[str], list[str]], text: str
) -> None:
    lines = refusal_of_study(text)
    assert len(lines) == 1, lines
    assert BAD[text] in lines[0]
