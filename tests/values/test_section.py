"""Types of values that several packages share have one place."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[2]
SHARED: Final = {
    r"2\s*\*\*\s*63(?! - 1\b)": "values/section.py",
    r'"ekf"|"ukf"': "laws/estimator.py",
}


def test_the_limit_of_seeds_and_the_names_of_estimators_stand_in_one_place() -> None:
    folders = {marker.parent for marker in ROOT.glob("*/__init__.py")} - {ROOT / "tests"}
    texts = {path: path.read_text() for folder in folders for path in folder.rglob("*.py")}
    assert len(texts) > 500
    for pattern, place in SHARED.items():
        found = {str(path.relative_to(ROOT)) for path in texts if re.search(pattern, texts[path])}
        assert found == {place}, pattern
