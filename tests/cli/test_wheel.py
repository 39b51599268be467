"""In a fresh environment without extras, the wheel runs a law from a folder of the user."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final
from zipfile import ZipFile

import pytest

from tests.idm import IDM

ROOT: Final = Path(__file__).parents[2]
SCENARIO: Final = """
description: eight vehicles under IDM, the second one brakes
duration_s: 30
seed: 1
fleet:
  size: 8
  gap_m: 50
control:
  model: "idm:smith"
  parameters: {headway_s: 1.3}
  desired_gap_m: 50
events:
  - {type: brake, vehicle: 2, at_s: 10, duration_s: 2, deceleration_mps2: 3}
"""
_OF_ANALYSIS: Final = ("matplotlib", "jinja2", "pyarrow")


def wheel(folder: Path) -> Path:
    """Build the wheel from a copy of the sources with the installed setuptools, or skip."""
    try:
        setuptools = int(version("setuptools").partition(".")[0])
    except PackageNotFoundError:
        setuptools = 0
    if setuptools < 77:
        pytest.skip("no setuptools >= 77 here, with which to build a wheel offline")
    source = folder / "source"
    tracked = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if tracked.returncode:
        pytest.skip("not a checkout: which files belong to the wheel is not known")
    for name in filter(None, tracked.stdout.split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, source / name)
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-index"]
    build += ["--no-build-isolation", "--wheel-dir", str(folder), str(source)]
    built = subprocess.run(build, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    (found,) = folder.glob("zenvoy-*.whl")
    return found


def environment(folder: Path, wheel: Path) -> Path:
    """Return the command `zenvoy` of a new environment with the wheel.

    This environment lends the dependencies, without the packages of the extra `analysis`.
    """
    venv.create(folder, with_pip=False, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    (lent,) = {Path(entry) for entry in sys.path if entry.endswith("site-packages")}
    left_out = ("zenvoy", "__editable__", *_OF_ANALYSIS)
    for entry in lent.iterdir():
        if not entry.name.lower().startswith(left_out) and entry.suffix != ".pth":
            (site / entry.name).symlink_to(entry)
    install = [sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python"), "install"]
    install += ["--quiet", "--no-deps", "--no-index", "--disable-pip-version-check", str(wheel)]
    subprocess.run(install, check=True)
    return folder / "bin" / "zenvoy"


def test_an_own_law_runs_with_the_wheel_alone(tmp_path: Path) -> None:
    made = wheel(tmp_path)
    page = {Path(name).suffix for name in ZipFile(made).namelist() if "/view/page/" in name}
    assert page == {".html", ".css", ".js", ".svg"}
    command = environment(tmp_path / "venv", made)
    place = tmp_path / "mine"
    place.mkdir()
    (place / "idm.py").write_text(IDM)
    (place / "s.yaml").write_text(SCENARIO)
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}

    def zenvoy(*arguments: str) -> str:
        done = subprocess.run(
            [str(command), *arguments],
            cwd=place,
            env=clean | {"COLUMNS": "120"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, ""), arguments
        return done.stdout

    zenvoy("check", "s.yaml", "--strict")
    zenvoy("run", "s.yaml", "--out", "processes")
    zenvoy("run", "s.yaml", "--bus", "in-process", "--out", "one")
    printed = [zenvoy("info", f"{name}/run.mcap") for name in ("processes", "one")]
    prints = [next(line for line in text.splitlines() if "fingerprint" in line) for text in printed]
    assert prints[0] == prints[1]
    for text in printed:
        assert "idm:smith#" in text
    where = [str(command.with_name("python")), "-c", "import zenvoy; print(zenvoy.__file__)"]
    found = subprocess.run(where, cwd=place, env=clean, capture_output=True, text=True, check=True)
    assert Path(found.stdout.strip()).is_relative_to(tmp_path / "venv")
