"""`import zenvoy` runs scenarios for a script or a notebook, and raises clear errors.

Scripts have their own process, since a process that has opened a Zenoh session cannot fork a fleet.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import zenvoy
from tests.conftest import zenvoy as command
from zenvoy.scenarios import Scenario

SCENARIO: Final = """
duration_s: 2
stall_limit_s: 60
fleet: {size: 3}
channel: {loss: {p: 0.2}}
"""
EXAMPLE: Final = Path(__file__).parents[2] / "examples" / "from_python.py"


def script(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    """Run a script as a user does: without a guard, from its own folder."""
    (folder / "s.yaml").write_text(SCENARIO)
    (folder / "script.py").write_text(text)
    return subprocess.run(
        [sys.executable, "script.py"], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text(SCENARIO)
    return tmp_path


def test_all_engines_and_the_command_give_the_same_bits(tmp_path: Path) -> None:
    text = """
import json, zenvoy
runs = [zenvoy.run("s.yaml", seed=7, engine=engine, out=engine)
        for engine in ("processes", "in-process", "arrays")]
json.dump([(run.fingerprint, run.summary["bus"], str(run.log)) for run in runs], open("found", "w"))
"""
    done = script(tmp_path, text)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")  # nothing is printed
    found = json.loads((tmp_path / "found").read_text())
    by_command = command(tmp_path, "run", "s.yaml", "--seed", "7", "--out", "c")
    assert by_command.code == 0, by_command.err
    expected = json.loads((tmp_path / "c" / "summary.json").read_text())["fingerprint"]
    assert found == [
        [expected, "zenoh", "processes/run.mcap"],
        [expected, "in-process", "in-process/run.mcap"],
        [expected, "arrays", "arrays/run.mcap"],
    ]
    files = {path.name for path in (tmp_path / "c").iterdir()}
    assert {path.name for path in (tmp_path / "processes").iterdir()} == files


def test_a_run_has_the_content_of_its_log(here: Path) -> None:
    seen: list[zenvoy.Progress] = []
    run = zenvoy.run("s.yaml", engine="in-process", out=here / "o", on_progress=seen.append)
    assert run.log == here / "o" / "run.mcap"
    assert run.truth["speed"].shape == (21, 3)
    assert run.estimate["ahead_gap"].shape == (20, 3)
    again = zenvoy.load(run.log)
    assert isinstance(again, zenvoy.Run)
    assert again.fingerprint == run.fingerprint
    assert again.summary == run.summary == json.loads((here / "o" / "summary.json").read_text())
    assert [progress.time_s for progress in seen] == [0.0, 1.0, 2.0]
    assert {progress.duration_s for progress in seen} == {2.0}


def test_changes_are_those_that_the_command_sets(here: Path) -> None:
    changes: dict[str, Any] = {
        "channel": {"loss": {"p": np.float64(0.5)}, "technology": "lte-a-pro"},
        "events": [{"vehicle": np.int64(2), "at_s": 1, "duration_s": 1, "deceleration_mps2": 2.5}],
        "control.v2v_wait_ms": 0,
    }
    changed = zenvoy.scenario("s.yaml", **changes)
    assert changed.name == "s"
    assert changed.scenario.channel.loss.p == 0.5
    assert changed.scenario.channel.technology.name == "lte-a-pro"
    assert changed.scenario.control.v2v_wait_ms == 0
    assert changed.scenario.fleet.size == 3  # other settings stay
    assert len(changed.scenario.events) == 1
    plain = zenvoy.run("s.yaml", engine="in-process")
    runs = [
        zenvoy.run(what, engine="in-process", seed=3)
        for what in (changed, changed.scenario, zenvoy.scenario("s.yaml", **changes, seed=3))
    ]
    assert len({run.fingerprint for run in runs}) == 1
    assert {run.seed for run in runs} == {3}
    assert runs[0].fingerprint != plain.fingerprint
    assert runs[0].log.parent.parent == Path("runs")


def test_errors_have_the_messages_of_the_command(here: Path) -> None:
    message = command(here, "check", "s.yaml", "--set", "channel.loss.p=1.4").err
    with pytest.raises(zenvoy.ScenarioError) as refused:
        zenvoy.scenario("s.yaml", channel={"loss": {"p": 1.4}})
    assert f"{refused.value}\n" == message.replace("(--set ", "(")
    assert str(refused.value).endswith("  (channel.loss.p=1.4)")
    with pytest.raises(zenvoy.ScenarioError, match=r"^seed: -1 is not in \[0.*  \(seed=-1\)$"):
        zenvoy.run("s.yaml", seed=-1)
    with pytest.raises(zenvoy.ScenarioError, match=r"^seed: -1 is not in \[0, 9223372036854"):
        zenvoy.run(Scenario(), seed=-1)
    with pytest.raises(zenvoy.ScenarioError, match=r"^seed: 'a' is not a whole number"):
        zenvoy.run("s.yaml", seed="a")  # type: ignore[arg-type]  # what a user may write
    with pytest.raises(zenvoy.ScenarioError, match=r"^'nope' is neither a file nor"):
        zenvoy.run("nope")
    with pytest.raises(zenvoy.ScenarioError, match=r"^seed: a value of type object is not allowed"):
        zenvoy.scenario("s.yaml", seed=object())
    with pytest.raises(zenvoy.InputError, match=r"^engine: 'x' is not one of processes, in-proc"):
        zenvoy.run("s.yaml", engine="x")  # type: ignore[arg-type]  # what a user may write
    with pytest.raises(zenvoy.InputError, match=r"^vehicles_per_process: 0: is not at least 1"):
        zenvoy.run("s.yaml", vehicles_per_process=0)
    with pytest.raises(zenvoy.InputError, match=r"^vehicles_per_process needs processes"):
        zenvoy.run("s.yaml", vehicles_per_process="auto", engine="arrays")
    with pytest.raises(zenvoy.InputError, match=r"^clock: realtime needs processes"):
        zenvoy.run(zenvoy.scenario("s.yaml", clock="realtime"), engine="in-process")
    with pytest.raises(zenvoy.FolderError, match=r"^out: \.: is not empty"):
        zenvoy.run("s.yaml", out=".")
    with pytest.raises(zenvoy.LogError, match=r"^s.yaml: "):
        zenvoy.load("s.yaml")
    assert not (here / "runs").exists()


def test_an_error_of_a_law_elsewhere_names_the_argument_that_runs_it(here: Path) -> None:
    (here / "laws").mkdir()
    (here / "laws" / "s.yaml").write_text("control: {model: '../law.py:LAW'}")
    (here / "law.py").write_text("")
    with pytest.raises(zenvoy.ScenarioError) as refused:
        zenvoy.scenario("laws/s.yaml")
    assert "; allow_code=True of zenvoy.scenario runs it  (laws/s.yaml, line 1)" in str(
        refused.value
    )
    with pytest.raises(zenvoy.ScenarioError, match=r"law\.py has no LAW"):
        zenvoy.scenario("laws/s.yaml", allow_code=True)


def test_a_process_that_dies_is_named(tmp_path: Path) -> None:
    text = """
import os, signal, zenvoy
from pathlib import Path

def kill(progress):
    for child in Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split():
        if b"vehicle-2" in Path(f"/proc/{child}/cmdline").read_bytes():
            os.kill(int(child), signal.SIGKILL)

try:
    zenvoy.run(zenvoy.scenario("s.yaml", duration_s=3600), on_progress=kill)
except zenvoy.ProcessLostError as error:
    print(error.process, error, zenvoy.load(error.log), sep="; ")
"""
    done = script(tmp_path, text.replace("vehicle-2", "vehicle-02"))
    assert done.stderr == ""
    name, error, run = done.stdout.split("; ")
    assert (name, error) == ("vehicle-02", "vehicle-02 died: killed by SIGKILL")
    assert run.startswith("<Run s, seed 1, 3 vehicles")


def test_a_run_in_a_process_with_a_session_fails_with_the_reason(tmp_path: Path) -> None:
    """Without this error the fleet would stall, and the error would name a vehicle."""
    text = """
import zenvoy
from zenvoy.bus.session import open_session
with open_session([], []):
    pass
try:
    zenvoy.run("s.yaml")
except zenvoy.RunError as error:
    print(error)
print(zenvoy.run("s.yaml", engine="in-process").result["end"])
"""
    done = script(tmp_path, text)
    assert done.stdout.startswith("the run cannot go on: this process has opened a Zenoh session")
    assert done.stdout.endswith("\ncomplete\n")


def test_an_exception_in_a_callback_ends_the_run(here: Path) -> None:
    def fail(progress: zenvoy.Progress) -> None:
        raise ArithmeticError(f"at {progress.time_s:g} s")

    with pytest.raises(ArithmeticError, match="at 0 s"):
        zenvoy.run("s.yaml", engine="in-process", out="o", on_progress=fail)
    assert zenvoy.load("o/run.mcap").result["end"] == "ArithmeticError: at 0 s"


def test_a_thread_may_run_a_fleet(here: Path) -> None:
    """A server or a user interface does so. Signals stay with the main thread."""
    found: list[str | None] = []

    def work() -> None:
        found.append(zenvoy.run("s.yaml", engine="in-process").fingerprint)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [zenvoy.run("s.yaml", engine="in-process").fingerprint]


def test_the_import_loads_no_heavy_modules() -> None:
    text = (
        "import sys, zenvoy; print({'numpy', 'zenoh', 'pydantic'} & set(sys.modules), zenvoy.run)"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("set() <function run")
    assert set(zenvoy.__all__) <= set(dir(zenvoy))
    assert zenvoy.__version__
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = zenvoy.nothing


def test_the_example_runs(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLE)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    assert header.startswith("frames lost")
    assert [int(row.split()[0]) for row in rows] == [0, 50, 90]
    assert sorted(os.listdir(tmp_path / "runs")) == ["lost-0", "lost-50", "lost-90"]
