"""The commands in the documentation have options that exist, and each is run by some test."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import pytest
import typer.main

from tests.cli.pages import ELSEWHERE, FOLLOWED, PAGES, ROOT, is_run_elsewhere
from tests.page_commands import commands_in_text, commands_of_blocks
from zenvoy.cli.app import app

GROUP: Final[Any] = typer.main.get_command(app)
TITLE: Final = re.compile(r"vehicle-\d")  # of a process
HELP: Final = {"-h", "--help", "--install-completion"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_have_options_that_exist(page: Path) -> None:
    text = page.read_text("utf-8")
    for typed in (*commands_in_text(text), *commands_of_blocks(text)):
        if typed.words[0] == "zenvoy" and not TITLE.match(typed.words[1]):
            assert_known(typed.words[1:])


def test_the_tests_of_pages_name_them_and_have_commands_to_run() -> None:
    for page, test in FOLLOWED.items():
        assert (ROOT / test).exists(), test
        assert (ROOT / "docs" / page).exists(), page
    typed = [one for page in PAGES for one in commands_of_blocks(page.read_text("utf-8"))]
    used = {start for start in ELSEWHERE if any(is_run_elsewhere(one, {start}) for one in typed)}
    assert used == set(ELSEWHERE)
    assert len(typed) > 80


def assert_known(words: Sequence[str]) -> None:
    """Check a command and its options. A page may leave out arguments and values."""
    found, rest = GROUP, list(words)
    while rest and hasattr(found, "commands") and rest[0] not in HELP:
        found = found.commands[rest.pop(0)]
    options = {option for one in found.params for option in one.opts} | HELP
    assert {word for word in rest if word.startswith("-")} <= options, words
