"""Every figure of a summary is a measure of sweeps."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from tests.conftest import run
from tests.studies.sweep_cases import SCENARIO
from zenvoy.analysis.measures.figures import MEASURES, figures


def leaves(value: object, name: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, f"{name}.{key}".removeprefix("."))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name


def test_every_figure_of_a_summary_is_a_measure(tmp_path: Path) -> None:
    run(tmp_path / "run", SCENARIO, "--bus", "in-process")
    summary = json.loads((tmp_path / "run" / "out" / "summary.json").read_text())
    numbers = set(leaves(summary)) - {"seed"}
    assert numbers <= set(MEASURES)
    assert {name for name, value in figures(summary).items() if value is not None} == numbers
