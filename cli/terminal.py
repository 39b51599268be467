"""Where the command writes."""

from __future__ import annotations

from typing import Final, NoReturn

import typer
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook, RenderResult
from rich.segment import Segment

from zenvoy.cli import exits

_NARROWEST: Final = 40  # columns at which tables can still be read
_USUAL: Final = 80
# A name may hold what a terminal would obey. U+2400 and the next picture it instead.
_CONTROLS: Final = {
    **{code: 0x2400 + code for code in range(0x20) if chr(code) not in "\n\t"},
    0x7F: 0x2421,
    **dict.fromkeys(range(0x80, 0xA0), 0xFFFD),
}


def visible(text: str) -> str:
    """The text without any character that a terminal would obey."""
    return text.translate(_CONTROLS)


class _Visible:
    """What is to be printed, made visible."""

    def __init__(self, shown: ConsoleRenderable) -> None:
        self._shown = shown

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for segment in console.render(self._shown, options):
            if segment.control:
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)


class _Texts(RenderHook):
    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        return [_Visible(shown) for shown in renderables]


def _console(*, stderr: bool) -> Console:
    """A console to which texts are texts: no markup, no emoji, nothing that moves the cursor."""
    made = Console(stderr=stderr, soft_wrap=stderr, highlight=False, markup=False, emoji=False)
    made.push_render_hook(_Texts())
    if made.width < _NARROWEST:  # with COLUMNS=0 nothing at all would be shown
        made.width = _USUAL
    return made


console = _console(stderr=False)
errors = _console(stderr=True)


def refuse(text: str) -> NoReturn:
    """Say in one line what is wrong with the input, and end."""
    errors.print(text)
    raise typer.Exit(exits.BAD_INPUT)
