"""Commands that are forked from the command server are like those that start an interpreter."""

from __future__ import annotations

import signal
from pathlib import Path

import psutil
import pytest

from tests.conftest import command, zenvoy


@pytest.mark.parametrize(
    "arguments",
    [
        ("--version",),
        ("run", "--help"),
        ("check", "nowhere"),
        ("run", "quickstart", "--duration-s", "0.5", "--engine", "in-process", "--out", "o"),
        ("technologies",),
    ],
    ids=" ".join,
)
def test_they_print_the_same(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    results = []
    for from_start in (False, True):
        folder = tmp_path / str(from_start)
        folder.mkdir()
        outcome = zenvoy(folder, *arguments, from_start=from_start)
        kept = [line for line in outcome.out.splitlines() if "× real time" not in line]
        results.append((outcome.code, kept, outcome.err))
    assert results[0] == results[1]


def test_a_signal_ends_one_with_a_session_of_its_own_and_its_title(tmp_path: Path) -> None:
    (tmp_path / "long.yaml").write_text("{duration_s: 100000, fleet: {size: 3}}")
    options = ("--engine", "in-process", "--out", "o")
    with command(tmp_path, "run", "long.yaml", *options) as started:
        started.wait_for_cycles(tmp_path / "o" / "run.mcap")
        process = psutil.Process(started.pid)
        assert "zenvoy run long.yaml" in " ".join(process.cmdline())
        assert process.parent() != psutil.Process()
        started.send_to_group(signal.SIGTERM)
        assert started.wait().code == 130


def test_one_that_has_settings_of_its_own_interpreter_gets_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text("print('customized')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    assert zenvoy(tmp_path, "--version").out.splitlines()[0] == "customized"
