"""A law may import modules beside it. Its hash covers them, and no other law sees them."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

import zenvoy as api
from tests.conftest import zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.studies.cell import Cell

LAW = """
from dataclasses import dataclass
from gains import K
from zenvoy.laws import Law
@dataclass(frozen=True)
class Parameters:
    share: float = 1.0
def acceleration(seen, own):
    from shapes.error import gap_error
    return own.share * K * gap_error(seen) + 0.5 * seen.ahead.v
LAW = Law(name="own", acceleration=acceleration, parameters=Parameters)
"""
ERROR = """
from . import scale
def gap_error(seen):
    return scale.ONE * (seen.ahead.p - seen.setpoint.p_des)
"""
SCENARIO = "{duration_s: 3, fleet: {size: 3}, control: {model: 'own:LAW'}}"
ESTIMATOR = """
from gains import K
from zenvoy.laws import Estimator
class Tracker:
    def __init__(self, model, z, R, own):
        self.x = z
    def step(self, inputs, z, R):
        self.x = self.x + K * (z - self.x)
        return self.x, R
LAW = Estimator(name="own", start=Tracker)
"""


def write(folder: Path, gain: float = 0.1, law: str = LAW, scenario: str = SCENARIO) -> Path:
    (folder / "shapes").mkdir(parents=True)
    (folder / "own.py").write_text(law)
    (folder / "gains.py").write_text(f"K = {gain}\n")
    (folder / "shapes" / "error.py").write_text(ERROR)
    (folder / "shapes" / "scale.py").write_text("ONE = 1.0\n")
    (folder / "s.yaml").write_text(scenario)
    return folder / "s.yaml"


CHANGES = {
    "gains.py": "K = 0.2\n",
    "shapes/error.py": f"{ERROR}\n#\n",
    "shapes/scale.py": "ONE = 2.0",
}


@pytest.mark.parametrize("changed", CHANGES)
def test_a_study_notices_a_change_in_a_module_beside_the_law(tmp_path: Path, changed: str) -> None:
    cell = Cell(scenario=str(write(tmp_path)), seed=1)
    before = cell.key()
    (tmp_path / "unrelated.py").write_text("K = 3.0\n")
    assert cell.key() == before
    (tmp_path / changed).write_text(CHANGES[changed])
    assert cell.key() != before


def test_a_study_notices_a_change_in_a_module_beside_an_estimator(tmp_path: Path) -> None:
    text = "{duration_s: 3, fleet: {size: 3}, estimator: {kind: 'own:LAW'}}"
    cell = Cell(scenario=str(write(tmp_path, law=ESTIMATOR, scenario=text)), seed=1)
    before = cell.key()
    (tmp_path / "gains.py").write_text("K = 0.2\n")
    assert cell.key() != before


def test_the_hash_equals_that_of_sha256sum(tmp_path: Path) -> None:
    model = api.scenario(write(tmp_path)).scenario.control.model
    files = ["gains.py", "own.py", "shapes/error.py", "shapes/scale.py"]
    command = f"sha256sum {' '.join(files)} | sha256sum"
    hashed = subprocess.run(
        command, shell=True, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert model == f"own:LAW#{hashed.stdout[:12]}"


def test_modules_of_two_folders_do_not_mix(tmp_path: Path) -> None:
    """Two folders have a `gains.py` each, and one process runs both in turn."""
    one = write(tmp_path / "one", 0.1)
    two = write(tmp_path / "two", 0.3)
    prints = [
        api.run(path, engine="in-process", out=tmp_path / str(number)).fingerprint
        for number, path in enumerate((one, two, one, two))
    ]
    assert prints[0] == prints[2] != prints[1] == prints[3]
    for name in ("gains", "shapes", "own"):
        assert name not in sys.modules
    assert str(tmp_path / "one") not in sys.path
    for path, expected in ((one, prints[0]), (two, prints[1])):
        outcome = zenvoy(tmp_path, "run", str(path), "--out", f"{path.parent.name}-alone")
        assert outcome.code == 0, outcome.err
        assert load(tmp_path / f"{path.parent.name}-alone" / "run.mcap").fingerprint == expected


def test_a_changed_module_is_loaded_again(tmp_path: Path) -> None:
    path = write(tmp_path / "s")
    before = api.run(path, engine="in-process", out=tmp_path / "before")
    (path.parent / "gains.py").write_text("K = 0.2\n")
    after = api.run(path, engine="in-process", out=tmp_path / "after")
    assert before.fingerprint != after.fingerprint
    references = [run.laws[pb.MODE_OWN].reference for run in (before, after)]
    assert references[0] != references[1]


def test_a_changed_module_is_noticed_before_anything_runs(tmp_path: Path) -> None:
    path = write(tmp_path)
    shown = zenvoy(tmp_path, "show", "s.yaml").out
    path.write_text(shown)
    assert zenvoy(tmp_path, "check", "s.yaml").code == 0
    (tmp_path / "gains.py").write_text("open('ran', 'w').close()\nK = 0.1\n")
    outcome = zenvoy(tmp_path, "check", "s.yaml")
    assert outcome.code == 2
    assert "its source has changed" in outcome.err
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        (
            "K = 1 / 0",
            "own.py cannot be run: ZeroDivisionError: division by zero (gains.py, line 1)",
        ),
        ("\nK = = 1", "own.py cannot be run: SyntaxError: invalid syntax (gains.py, line 2)"),
        ("L = 1", "own.py cannot be run: ImportError: cannot import name 'K' from 'gains' ("),
        (
            None,
            "own.py cannot be run: ModuleNotFoundError: No module named 'gains' (own.py, line 3)",
        ),
    ],
)
def test_a_module_that_cannot_be_run_is_named(
    tmp_path: Path, gains: str | None, message: str
) -> None:
    write(tmp_path)
    (tmp_path / "gains.py").unlink()
    if gains is not None:
        (tmp_path / "gains.py").write_text(gains)
    outcome = zenvoy(tmp_path, "check", "s.yaml")
    assert outcome.code == 2
    assert outcome.err.startswith(f"control.model: 'own:LAW': {message}")
    assert len(outcome.err.splitlines()) == 1


@pytest.mark.parametrize("name", ["statistics.py", "zenvoy/__init__.py", "zenvoy/laws.py"])
def test_python_and_zenvoy_come_before_modules_beside(tmp_path: Path, name: str) -> None:
    write(tmp_path, law=f"import statistics\nstatistics.mean([1.0])\n{LAW}")
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("raise RuntimeError\n")
    outcome = zenvoy(tmp_path, "check", "s.yaml")
    assert (outcome.code, outcome.err) == (0, "")


@pytest.mark.parametrize(
    "form", ["import {}.gains as g", "from {} import gains as g", "from . import gains as g"]
)
def test_the_hash_covers_all_that_a_law_imports_of_an_installed_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, form: str
) -> None:
    site, scenarios = tmp_path / "site", tmp_path / "scenarios"
    name = f"smiths_{hashlib.sha256(form.encode()).hexdigest()[:8]}"
    package, facts = site / name, site / f"{name}-1.2.dist-info"
    for folder in (package, facts, scenarios):
        folder.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "gains.py").write_text("K = 0.1\n")
    (package / "other.py").write_text("")
    (package / "law.py").write_text(
        f"{form.format(name)}\nfrom zenvoy.laws import Law\n"
        "def law(seen, own):\n    return g.K * seen.ahead.v\n"
        "LAW = Law(name='Smith', acceleration=law)\n"
    )
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n")
    (facts / "top_level.txt").write_text(f"{name}\n")
    monkeypatch.setenv("PYTHONPATH", str(site))
    (scenarios / "s.yaml").write_text(f"control: {{model: '{name}.law:LAW'}}\n")

    def model() -> str:
        outcome = zenvoy(scenarios, "show", "s.yaml")
        assert outcome.code == 0, outcome.err
        return next(line for line in outcome.out.splitlines() if "model:" in line)

    before = model()
    assert f"{name}.law:LAW#" in before
    (package / "other.py").write_text("K = 2\n")
    assert model() == before
    (package / "gains.py").write_text("K = 0.2\n")
    assert model() != before


def test_an_imported_package_that_has_changed_since_is_not_run_under_a_new_hash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    (tmp_path / "site").mkdir()
    law = tmp_path / "site" / "changing_laws.py"
    law.write_text(
        "from zenvoy.laws import Law\nLAW = Law(name='C', acceleration=lambda s, p: 0.0)\n"
    )
    (tmp_path / "s.yaml").write_text("control: {model: 'changing_laws:LAW'}\n")
    api.scenario(tmp_path / "s.yaml", allow_code=True)
    law.write_text(f"{law.read_text()}#\n")
    with pytest.raises(api.ScenarioError, match="has changed since it was imported"):
        api.scenario(tmp_path / "s.yaml", allow_code=True)
