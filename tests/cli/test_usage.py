"""The command line has version, help and completion, and one clear line for wrong usage."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import pytest
import typer.main
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import LIMIT_S, Outcome, zenvoy
from zenvoy.cli.app import app
from zenvoy.cli.usage import App, outcome

GROUP: Final[Any] = typer.main.get_command(app)
COMMANDS: Final[dict[str, Any]] = dict(GROUP.commands)


def options() -> Iterator[tuple[str, str]]:
    """Yield every option of every command that takes one value."""
    for name, command in COMMANDS.items():
        for option in command.params:
            if option.param_type_name == "option" and not option.multiple and not option.is_flag:
                yield from ((name, opt) for opt in option.opts)


def run_here(capsys: pytest.CaptureFixture[str], *arguments: str) -> Outcome:
    """Run a command line in this process, and return its outcome."""
    code = outcome(app, arguments)
    return Outcome(code, *capsys.readouterr())


def test_the_version_equals_that_of_the_package(tmp_path: Path) -> None:
    assert zenvoy(tmp_path, "--version") == Outcome(0, f"zenvoy {version('zenvoy')}\n", "")


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_has_two_options(capsys: pytest.CaptureFixture[str], command: str) -> None:
    path = [command] if command else []
    short, long = run_here(capsys, *path, "-h"), run_here(capsys, *path, "--help")
    assert short == long
    assert (short.code, short.err) == (0, "")
    assert short.out.startswith(" ".join(["Usage:", *short.out.split()[1:2], *path]))
    assert "-h, --help" in short.out


@pytest.mark.parametrize(("command", "option"), list(options()))
def test_an_option_with_one_value_is_accepted_once(
    capsys: pytest.CaptureFixture[str], command: str, option: str
) -> None:
    refused = run_here(capsys, command, option, "1", option, "2")
    assert refused == Outcome(2, "", f"{option}: given 2 times; allowed: once\n")
    refused = run_here(capsys, command, f"{option}=1", "x", option, "1", f"{option}=1")
    assert refused == Outcome(2, "", f"{option}: given 3 times; allowed: once\n")
    assert run_here(capsys, command, option, "1", option, "2", "--help").code == 0


def test_options_with_one_value_exist() -> None:
    assert {("run", "--seed"), ("run", "--out"), ("vehicle", "--id"), ("export", "--to")} <= set(
        options()
    )


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("run", "zenvoy run: missing argument 'SCENARIO'; see zenvoy run --help"),
        ("run a b", "zenvoy run: got unexpected extra argument(s) (b); see zenvoy run --help"),
        ("run a --seed", "Option '--seed' requires an argument."),
        ("run a --seed x", "--seed x: is not a whole number"),
        ("run a --duration-s x", "--duration-s x: is not a number"),
        ("run a --bus can", "--bus can: is not one of 'zenoh', 'in-process'"),
        ("run a --realtime=1", "Option '--realtime' does not take a value."),
        ("run a --without 1.5", "--without 1.5: is not a whole number"),
        ("reproduce --seeds 1", "--seeds 1: is not at least 2"),
        ("reproduce --seeds 1e3", "--seeds 1e3: is not a whole number"),
        ("degradation --seeds 10001", "--seeds 10001: is not at most 10000"),
        (
            "degradation --duration-s nan",
            "duration_s: nan is not in (0, 1e9]  (--duration-s nan)",
        ),
        ("degradation --out file/x", "--out file/x: Not a directory"),
        ("mixed-traffic --out file/x", "--out file/x: Not a directory"),
        ("mixed-traffic --out o --runs file/x", "--runs file/x: Not a directory"),
        ("reproduce --runs file --out new", "--runs file: File exists"),
        ("vehicle --run r", "zenvoy vehicle: missing option '--id'; see zenvoy vehicle --help"),
        (
            "export r.mcap",
            "zenvoy export: missing option '--to'. Choose from: parquet, csv; "
            "see zenvoy export --help",
        ),
        ("info", "zenvoy info: missing argument 'RUN.mcap'; see zenvoy info --help"),
        ("nope", "zenvoy: no such command 'nope'; see zenvoy --help"),
        ("--nope", "zenvoy: no such option: --nope; see zenvoy --help"),
    ],
)
def test_bad_usage_is_reported_in_one_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    line: str,
    message: str,
) -> None:
    monkeypatch.setattr(sys, "argv", ["zenvoy"])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    assert run_here(capsys, *line.split()) == Outcome(2, "", f"{message}\n")


@given(
    st.sampled_from([name for name in COMMANDS if name not in {"scenarios", "technologies"}]),
    st.lists(st.text(st.characters(exclude_categories=["Cs"]), max_size=8), max_size=3),
)
def test_no_command_line_ends_in_a_traceback(command: str, words: list[str]) -> None:
    """An unknown option keeps the command from doing anything, whatever else is given."""
    if command in {"-h", "--help"}:
        return
    assert outcome(app, [command, "--no-such-option", *words]) in {0, 2}


def test_a_shell_completes_scenarios(tmp_path: Path) -> None:
    (tmp_path / "zenvoy").symlink_to(Path(sys.executable).with_name("zenvoy"))
    asked = """
        eval "$(_ZENVOY_COMPLETE=source_bash zenvoy)"
        try() {
            COMP_WORDS=(zenvoy "$@") COMP_CWORD=$#
            _zenvoy_completion zenvoy
            echo ${COMPREPLY[@]}
        }
        try run technologies/i
        try run mine
        try check quickst
        try run quickstart --bus in
        try deg
    """
    done = subprocess.run(
        ["bash", "-c", asked],
        cwd=tmp_path,
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        capture_output=True,
        timeout=3 * LIMIT_S,
        check=True,
    )
    assert (done.stdout.decode().splitlines(), done.stderr) == (
        [
            "technologies/ieee80211p technologies/ieee80211px",
            "",
            "quickstart",
            "in-process",
            "degradation",
        ],
        b"",
    )


@pytest.mark.parametrize(
    ("missing", "extra"),
    [
        ("matplotlib", "analysis"),
        ("jinja2", "analysis"),
        ("pyarrow", "analysis"),
        ("optuna", "tune"),
        ("sqlalchemy", "tune"),
    ],
)
def test_a_missing_package_of_the_extra_is_named(
    missing: str, extra: str, capsys: pytest.CaptureFixture[str]
) -> None:
    alone = App()

    @alone.command()
    def draw() -> None:
        raise ModuleNotFoundError(f"No module named '{missing}.sub'", name=f"{missing}.sub")

    assert outcome(alone, []) == 1
    expected = f"{missing} is not installed; run: pip install 'zenvoy[{extra}]'\n"
    assert capsys.readouterr().err == expected
