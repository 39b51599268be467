"""The notebooks of examples/notebooks run from their first cell to their last."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import nbformat
import pytest
from nbclient import NotebookClient

from tests.conftest import LIMIT_S

FOLDER: Final = Path(__file__).parents[2] / "examples" / "notebooks"
NOTEBOOKS: Final = sorted(FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells)  # they would be out of date
    here = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(
        notebook, resources=here, timeout=int(2 * LIMIT_S), startup_timeout=int(LIMIT_S)
    ).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert any("image/png" in output.get("data", {}) for output in shown)
    assert (tmp_path / "mine" / "run.mcap").exists()
