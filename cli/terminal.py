"""The consoles that the command prints to."""

from __future__ import annotations

from typing import Final, NoReturn

import typer
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook, RenderResult
from rich.segment import Segment

from zenvoy.cli import exits

_LEAST_WIDTH: Final = 40  # characters at which tables are still legible
_DEFAULT_WIDTH: Final = 80
# A name may hold control characters. U+2400 and its successors are pictures of them.
_CONTROLS: Final = {
    **{code: 0x2400 + code for code in range(0x20) if chr(code) not in "\n\t"},
    0x7F: 0x2421,
    **dict.fromkeys(range(0x80, 0xA0), 0xFFFD),
}


def visible(text: str) -> str:
    """Return the text with its control characters replaced by pictures of them."""
    return text.translate(_CONTROLS)


class _Visible:
    """Renders something with its control characters made visible."""

    def __init__(self, shown: ConsoleRenderable) -> None:
        self._shown = shown

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for segment in console.render(self._shown, options):
            if segment.control:
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)


class _MakeVisible(RenderHook):
    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        return [_Visible(shown) for shown in renderables]


def _console(*, stderr: bool) -> Console:
    """Return a console that prints text literally: no markup, no emoji, no control characters."""
    made = Console(stderr=stderr, soft_wrap=stderr, highlight=False, markup=False, emoji=False)
    made.push_render_hook(_MakeVisible())
    if made.width < _LEAST_WIDTH:  # with COLUMNS=0 rich would print nothing
        made.width = _DEFAULT_WIDTH
    return made


console = _console(stderr=False)
errors = _console(stderr=True)


def has_screen(made: Console) -> bool:
    """Return whether a console is a terminal on which the cursor can be placed."""
    return made.file.isatty() and made.is_terminal and not made.is_dumb_terminal


def say(text: str) -> None:
    """Print a line, which is not wrapped."""
    console.print(text, soft_wrap=True)


def refuse(text: str) -> NoReturn:
    """Print what is wrong with the input, and exit."""
    errors.print(text)
    raise typer.Exit(exits.BAD_INPUT)
