"""A helper loads a scenario that must be refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from zenvoy.scenarios import ScenarioError, load


def refused(folder: Path, text: str) -> list[str]:
    """Write a scenario to `s.yaml` in `folder`, and return the lines with which it is refused."""
    path = folder / "s.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as error:
        load(path)
    return str(error.value).splitlines()
