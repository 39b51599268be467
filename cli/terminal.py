"""The command `zenvoy` itself, where it writes, and how it ends."""

from __future__ import annotations

from types import FrameType
from typing import NoReturn

import typer
from rich.console import Console

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
EXIT_PROCESS_LOST = 3
EXIT_INTERRUPTED = 130

app = typer.Typer(
    name="zenvoy",
    help="Emulates convoys of vehicles that talk to each other.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
console = Console(soft_wrap=False)
errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)


def refuse(text: str) -> NoReturn:
    """Say in one line what is wrong with the input, and end."""
    errors.print(text)
    raise typer.Exit(EXIT_BAD_INPUT)


def interrupt(_signal: int, _frame: FrameType | None) -> None:
    """End as Ctrl-C does."""
    raise KeyboardInterrupt
