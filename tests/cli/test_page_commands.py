"""The commands in the documentation have options that exist, and each is run by some test."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import pytest
import typer.main

from tests.cli.pages import ELSEWHERE, FOLLOWED, NOT_RUN, PAGES, ROOT, begins_as
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


@pytest.mark.parametrize("page", FOLLOWED)
def test_a_page_that_is_a_story_has_a_test_that_reads_it(page: str) -> None:
    assert f'"{page}"' in (ROOT / FOLLOWED[page]).read_text("utf-8")


def test_each_exception_is_for_some_command_and_names_tests_that_exist() -> None:
    typed = [one for page in PAGES for one in commands_of_blocks(page.read_text("utf-8"))]
    starts = {*ELSEWHERE, *NOT_RUN}
    assert {start for start in starts if any(begins_as(one, {start}) for one in typed)} == starts
    assert all((ROOT / re.split("[ ,]", where)[0]).exists() for where in ELSEWHERE.values())
    left = [one for one in typed if not begins_as(one, starts)]
    assert {one.words[0] for one in left} == {"zenvoy", "python", "python3", "dask"}


def assert_known(words: Sequence[str]) -> None:
    """Check a command and its options. A page may leave out arguments and values."""
    found, rest = GROUP, list(words)
    while rest and hasattr(found, "commands") and rest[0] not in HELP:
        found = found.commands[rest.pop(0)]
    options = {option for one in found.params for option in one.opts} | HELP
    assert {word for word in rest if word.startswith("-")} <= options, words
