"""Files that extend each other, and the messages with which they are refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.refusals import refusal_of

Write = Callable[..., None]

BASE = """\
description: the base
seed: 7
fleet: {size: 9, gap_m: 50}
control:
  model: FM
  schedule: [{at_s: 10, model: BCM}]
  gains: {k_d: 0.2, k_v: 0.6}
events: [{vehicle: 9, at_s: 10, duration_s: 2, deceleration_mps2: 3}]
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Return a function that writes files by path, below the current folder."""
    monkeypatch.chdir(tmp_path)

    def write_them(texts: Mapping[str, str]) -> None:
        for path, text in texts.items():
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            Path(path).write_text(text)

    return write_them


@pytest.fixture
def packaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Write) -> Write:
    """Return a function that writes built-in scenarios, in place of those of the package."""
    monkeypatch.setattr("zenvoy.scenarios.reading.library.files", lambda _: tmp_path / "package")
    return lambda texts: write({f"package/{path}": text for path, text in texts.items()})


def problems(*settings: str, name: str = "s.yaml", **options: Any) -> list[str]:
    """Return the messages with which a scenario is refused, one for each problem."""
    return refusal_of(name, *settings, **options).splitlines()
