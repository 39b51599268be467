"""The commands and the Python code of docs/compare-laws.md run as they are, with fewer seeds."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Final

from tests.conftest import zenvoy
from tests.docs_blocks import blocks
from zenvoy.studies.comparison.comparing import MEASURED, SEEDS

PAGE: Final = (Path(__file__).parents[3] / "docs" / "compare-laws.md").read_text()


def block(language: str) -> str:
    return blocks(PAGE, language)[0]


def test_the_page_leads_from_an_empty_folder_to_a_picture(tmp_path: Path) -> None:
    for line in block("sh").splitlines():
        program, *arguments = shlex.split(line.replace("--seeds 30", "--seeds 2"))
        assert program == "zenvoy"
        outcome = zenvoy(tmp_path, *arguments)
        assert (outcome.code, outcome.err) == (0, ""), outcome
    out = tmp_path / "laws"
    rows = re.search(r"\| file in the folder.*?\n\n", PAGE, re.DOTALL)
    assert rows is not None
    files = {name.rstrip("/") for name in re.findall(r"`([\w./-]+)`(?=[,| ])", rows[0])}
    assert {path.name for path in out.iterdir()} == files
    code = block("python").replace("seeds=30", "seeds=2")
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    first, *printed = done.stdout.splitlines()
    assert first == "4 cells × 2 seeds: 8 runs, 0 to do"
    ratios = {line.split()[0]: float(line.split()[1]) for line in printed[1:-1]}
    assert ratios["FM"] > 1.0  # as the page says
    assert max(ratios[law] for law in ("mine", "BCM", "PBCM")) < 1.0


def test_the_page_has_the_message_of_a_bad_comparison(tmp_path: Path) -> None:
    command, *lines = block("console").splitlines()
    _, program, *arguments = shlex.split(command)
    assert program == "zenvoy"
    outcome = zenvoy(tmp_path, *arguments)
    assert (outcome.code, outcome.err.splitlines()) == (2, lines)


def test_the_page_has_every_option_and_the_measures(tmp_path: Path) -> None:
    usage = zenvoy(tmp_path, "compare-laws", "--help").out
    options = set(re.findall(r"^ +(--[\w-]+)", usage, re.MULTILINE)) - {"--help"}
    assert len(options) == 10
    for option in options - {"--allow-code"}:
        assert f"| `{option}` |" in PAGE, option
    assert "`--allow-code`" in PAGE
    assert all(f"`{name}`" in PAGE for name in MEASURED)
    assert f"| number of seeds: 1, 2, and so on | {SEEDS} |" in PAGE
