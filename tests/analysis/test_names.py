"""Names are shown as plain text on terminals, in pictures, on pages and in tables."""

from __future__ import annotations

import csv
import os
import pty
from io import StringIO
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.cbook import is_math_text
from rich.console import Console
from rich.table import Table

from tests.analysis.test_export import read as read_table
from tests.conftest import LIMIT_S, Outcome, command, wait_until, zenvoy
from tests.logs import write_log
from tests.pages import read
from zenvoy.analysis.log.cells import harmless
from zenvoy.analysis.log.export import export
from zenvoy.analysis.log.load import load
from zenvoy.analysis.page import style
from zenvoy.analysis.page.files import csv_bytes
from zenvoy.analysis.page.section import Sheet
from zenvoy.bus.text import utf8
from zenvoy.cli import terminal
from zenvoy.cli.analyze import compare

SHORT: Final = "{duration_s: 1, fleet: {size: 3}}"
NASTY: Final = r"[b]sc[red]:smile::1234:$x$ $\frac{<i>&amp;"
FORMULAS: Final = ("=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", " =1", "\t=1", "a;=1", "＝1")


@pytest.mark.parametrize("console", [terminal.console, terminal.errors], ids=["out", "err"])
def test_a_console_shows_a_text_as_it_is(
    console: Console, capsys: pytest.CaptureFixture[str]
) -> None:
    table = Table(NASTY, title=NASTY, width=78)
    table.add_row(NASTY)
    console.print(NASTY, soft_wrap=True)
    console.print(table, soft_wrap=False)
    text = "".join(capsys.readouterr())
    assert text.count(NASTY) == 4


def test_control_characters_do_not_reach_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.console.print("a\x1b[31mb\x07\x9bc\x7fd")
    assert capsys.readouterr().out == "a␛[31mb\ufffdc␡d\n"


def test_output_of_a_run_shows_its_name(tmp_path: Path) -> None:
    (tmp_path / f"{NASTY}.yaml").write_text(SHORT)
    outcome = zenvoy(tmp_path, "check", f"{NASTY}.yaml")
    assert outcome == Outcome(0, f"{NASTY}: valid; 3 vehicles, 1 s\nruns on arrays\n", "")
    outcome = zenvoy(tmp_path, "run", f"{NASTY}.yaml", "--out", "m[/b]", "--bus", "in-process")
    assert (outcome.code, outcome.err) == (0, "")
    assert f"{NASTY}, seed 1" in outcome.out
    assert outcome.out.splitlines()[-1] == "written to m[/b]"
    outcome = zenvoy(tmp_path, "info", "m[/b]/run.mcap")
    assert NASTY in outcome.out
    outcome = zenvoy(tmp_path, "info", "[red]x")
    assert (outcome.code, outcome.err.startswith("[red]x: ")) == (2, True)


def test_progress_shows_the_name(tmp_path: Path) -> None:
    (tmp_path / "s[b]\x1b[31m.yaml").write_text("{duration_s: 100000, fleet: {size: 3}}")
    master, slave = pty.openpty()
    shown = b""

    def name() -> bool:
        nonlocal shown
        shown += os.read(master, 65_536)
        return "s[b]␛[31m".encode() in shown

    try:
        options = ["--out", "o", "--bus", "in-process"]
        env = {"TERM": "xterm-256color", "PYTHONIOENCODING": "utf-8"}
        with command(tmp_path, "run", "s[b]\x1b[31m.yaml", *options, env=env, stdout=slave):
            wait_until(name, "the bar has a name", LIMIT_S)
    finally:
        os.close(slave)
        os.close(master)


def test_a_comparison_shows_names_as_they_are(tmp_path: Path) -> None:
    labels = ['=HYPERLINK("x","y")', f"{NASTY}\x1b\udcff"]
    logs = [write_log(tmp_path / f"={number}.mcap", SHORT) for number in (1, 2)]
    out = tmp_path / "out"
    shown = StringIO()
    console = Console(file=shown, width=400, markup=False, emoji=False)
    assert compare(logs, labels, out, console, terminal.errors) == 0
    text = shown.getvalue()
    assert labels[0] in text
    assert NASTY in text
    page = read((out / "compare.html").read_text(encoding="utf-8"))
    assert any(f"{NASTY}\\x1b\\udcff" in text for texts in page.text.values() for text in texts)
    for picture in out.glob("*.svg"):
        ElementTree.parse(picture)
    cells = [cell for table in out.glob("*.csv") for cell in cells_of(table.read_bytes())]
    assert f"'{labels[0]}" in cells
    assert not any(cell.startswith("=") for cell in cells)


def cells_of(table: bytes) -> list[str]:
    """Return all cells of a CSV as texts."""
    return [cell for row in csv.reader(StringIO(table.decode(), newline="")) for cell in row]


@pytest.mark.parametrize("text", FORMULAS)
def test_a_formula_is_made_harmless(text: str) -> None:
    sheet = Sheet(name="s", title="S", columns=(text, "b"), rows=((text, -1.5), (None, "-1e3")))
    title, _, cell, *numbers = cells_of(csv_bytes(sheet))
    assert title == cell != text
    assert cell.replace("'=", "=").removeprefix("'") == text
    assert numbers == ["-1.5", "", "-1e3"]


@given(st.text(max_size=12))
def test_no_text_in_a_csv_begins_like_a_formula(text: str) -> None:
    cell = str(harmless(text))
    assert len(cell) - len(text) == cell.count("'") - text.count("'")
    for part in cell.replace("\t", ";").replace("\n", ";").replace("\r", ";").split(";"):
        try:
            float(cell)
        except ValueError:
            assert part.strip()[:1] not in set("=+-@＝＋－＠")


def test_an_export_as_csv_has_no_formula(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "run.mcap", SHORT, until_cycle=5, lost="=cmd|' /C calc'!A0"))
    export(run, tmp_path, "csv")
    export(run, tmp_path, "parquet")
    assert read_table("csv", tmp_path, "events")["text"][-1] == "'=cmd|' /C calc'!A0"
    assert read_table("parquet", tmp_path, "events")["text"][-1] == "=cmd|' /C calc'!A0"


@given(st.text())
def test_no_text_of_a_picture_is_mathematics(text: str) -> None:
    shown = style.plain(text)
    assert not is_math_text(shown)
    assert shown.isprintable()
    if text.isprintable():
        assert shown.replace(r"\$", "$").strip() == text.strip()


@given(st.text(st.characters()))
def test_every_text_can_be_written(text: str) -> None:
    utf8(text).decode()
