"""The command ends on request while it starts, and works in locales without UTF-8."""

from __future__ import annotations

import ast
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import LIMIT_S, Command, Outcome, command, wait_until
from tests.logs import write_log
from tests.test_imports import MODULES, ROOT

SHORT: Final = "{duration_s: 1, fleet: {size: 3}, description: 'Größe ≥ 模'}"
C: Final = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
LATIN: Final = {"PYTHONIOENCODING": "latin-1"}


def handled(started: Command, kind: str) -> set[int]:
    """Return the signals that the command catches ("SigCgt") or ignores ("SigIgn")."""
    status = Path(f"/proc/{started.pid}/status").read_text(encoding="ascii")
    found = re.search(rf"{kind}:\s+([0-9a-f]+)", status)
    mask = int(found[1], 16) if found else 0
    return {number for number in range(1, 32) if mask >> (number - 1) & 1}


def maps(started: Command) -> str:
    """Return the files that the command has mapped: the libraries that it has imported so far."""
    return Path(f"/proc/{started.pid}/maps").read_text(encoding="utf-8")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("imported", ["", "pydantic_core", "_multiarray_umath", "_imaging"])
def test_a_request_during_imports_ends_the_command_in_silence(
    tmp_path: Path, number: signal.Signals, imported: str
) -> None:
    write_log(tmp_path / "run.mcap", SHORT)  # its analysis takes long enough for a slow test
    with command(tmp_path, "analyze", "run.mcap", from_start=True) as started:
        wait_until(lambda: signal.SIGTERM in handled(started, "SigCgt"), "it has begun")
        wait_until(lambda: imported in maps(started), f"{imported} is imported")
        started.send(number)
        assert started.wait() == Outcome(130, "", "")


def test_nohup_is_respected(tmp_path: Path) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with command(tmp_path, "check", "quickstart", from_start=True) as started:
            wait_until(lambda: signal.SIGTERM in handled(started, "SigCgt"), "it has begun")
            started.send(signal.SIGHUP)
            assert started.wait() == Outcome(
                0, "quickstart: valid; 20 vehicles, 60 s\nruns on arrays\n", ""
            )
        (tmp_path / "s.yaml").write_text("{duration_s: 100000, fleet: {size: 3}}")
        options = ["--out", "o", "--bus", "in-process"]
        with command(tmp_path, "run", "s.yaml", *options, from_start=True) as started:
            started.wait_for_cycles(tmp_path / "o" / "run.mcap")
            assert signal.SIGHUP in handled(started, "SigIgn")
    finally:
        signal.signal(signal.SIGHUP, before)


def all_of(cwd: Path, env: dict[str, str], *lines: Sequence[str]) -> list[tuple[int, bytes, bytes]]:
    """Return exit codes, outputs and errors of commands that run at the same time."""
    started = [
        subprocess.Popen(
            [sys.executable, "-m", "zenvoy.cli", *line],
            cwd=cwd,
            env={**os.environ, "COLUMNS": "200", **env},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for line in lines
    ]
    results = [process.communicate(timeout=3 * LIMIT_S) for process in started]
    return [(p.returncode, *of) for p, of in zip(started, results, strict=True)]


@pytest.mark.parametrize(("env", "encoding"), [(C, "ascii"), (LATIN, "latin-1")])
def test_output_has_only_characters_that_the_terminal_can_show(
    tmp_path: Path, env: dict[str, str], encoding: str
) -> None:
    (tmp_path / "süd-模.yaml").write_text(SHORT, encoding="utf-8")
    check, technologies, show = all_of(
        tmp_path, env, ["check", "süd-模.yaml"], ["technologies"], ["show", "süd-模.yaml"]
    )
    name = "süd-模".encode(encoding, "backslashreplace")
    assert check == (0, name + b": valid; 3 vehicles, 1 s\nruns on arrays\n", b"")
    assert (technologies[0], technologies[2]) == (0, b"")
    assert b">= 640 MHz" in technologies[1]
    again = tmp_path / "again.yaml"
    again.write_bytes(show[1])  # nothing is lost: the scenario is shown the same again
    [(_, whole, _)] = all_of(tmp_path, {"PYTHONIOENCODING": "utf-8"}, ["show", "again.yaml"])
    assert 'description: "Größe ≥ 模"' in whole.decode()


def test_all_files_are_written_in_an_ascii_locale(tmp_path: Path) -> None:
    for name in ("süd-模", "nord"):
        write_log(tmp_path / f"{name}.mcap", SHORT)  # and its scenario, as YAML
    labels = ["--label", "模", "--label", "ü"]
    results = all_of(
        tmp_path,
        C,
        ["run", "süd-模.yaml", "--out", "läuft", "--bus", "in-process"],
        ["analyze", "süd-模.mcap"],
        ["compare", "süd-模.mcap", "nord.mcap", *labels, "--out", "beide"],
        ["info", "süd-模.mcap"],
        ["export", "süd-模.mcap", "--to", "csv", "--out", "tafeln"],
        ["channel", "süd-模.yaml", "--out", "kanal"],
    )
    assert [(code, err) for code, _, err in results] == [(0, b"")] * len(results)
    assert all(out.isascii() for _, out, _ in results)
    for path in ("läuft/summary.json", "süd-模-analysis/report.html", "beide/compare.html"):
        assert "模" in (tmp_path / path).read_text(encoding="utf-8")
    assert (tmp_path / "kanal" / "channel.html").exists()
    assert len(list((tmp_path / "tafeln").iterdir())) == 7


def texts_without_encoding(source: str) -> Iterator[str]:
    """Yield the calls that open a file as text and leave the encoding to the locale."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        given = {keyword.arg for keyword in node.keywords}
        if any(ast.unparse(argument) in {"'utf-8'", "'ascii'"} for argument in node.args):
            continue
        modes = [*node.args, *(k.value for k in node.keywords if k.arg == "mode")]
        binary = any(isinstance(mode, ast.Constant) and "b" in str(mode.value) for mode in modes)
        of_os = isinstance(node.func, ast.Attribute) and ast.unparse(node.func.value) in {
            "os",
            "zenoh",
        }
        opens = name in {"open", "fdopen", "TextIOWrapper"} and not binary and not of_os
        if (opens or name in {"read_text", "write_text"}) and "encoding" not in given:
            yield f"line {node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_are_utf8_whatever_the_locale(path: Path) -> None:
    assert list(texts_without_encoding(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    "source", ["open(p)", "p.open('w')", "p.read_text()", "p.write_text(t)", "open(p, mode='a')"]
)
def test_a_text_without_encoding_is_found(source: str) -> None:
    assert len(list(texts_without_encoding(source))) == 1
