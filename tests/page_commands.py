"""The commands of the documentation, and how a test makes them short."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from tests.docs_blocks import named_blocks

_INLINE: Final = re.compile(r"`(zenvoy [^`]+)`")
_PROMPT: Final = "$ "

# A value for each option that is as good as the page's, and takes less time.
_SHORTER: Final = {"--duration-s": "2", "--seeds": "1", "--bursts": "1"}
_MORE_SEEDS: Final = {"mixed-traffic": "2"}  # it refuses one seed, because that has no interval
_WITH_DURATION: Final = ("run", "serve")


@dataclass(frozen=True, slots=True)
class Typed:
    """The words of a command on a page, and the lines that the page shows below it."""

    words: tuple[str, ...]
    shown: tuple[str, ...] = ()


def commands_of_blocks(page: str) -> list[Typed]:
    """Return all commands in the blocks of a page, in order."""
    found: list[Typed] = []
    for language, _, body in named_blocks(page):
        if language not in {"sh", "console"}:
            continue
        for line in body.replace("\\\n", " ").splitlines():
            if language == "sh" or line.startswith(_PROMPT):
                found += [Typed(words) for words in _commands(line.removeprefix(_PROMPT))]
            else:
                last = found.pop()
                found.append(Typed(last.words, (*last.shown, line)))
    return found


def commands_in_text(page: str) -> list[Typed]:
    """Return the commands of Zenvoy that stand between the words of a page."""
    text = re.sub(r"^```.*?^```$", "", page, flags=re.MULTILINE | re.DOTALL)
    lines = [line.replace("\n", " ") for line in _INLINE.findall(text)]
    return [Typed(words) for line in lines for words in _commands(line)]


def shortened(words: tuple[str, ...]) -> list[str]:
    """Return a command that does the same for a shorter time, or with fewer seeds."""
    short = list(words)
    for option, value in _SHORTER.items():
        if option in short:
            short[short.index(option) + 1] = value
    if words[1:2] and words[1] in _MORE_SEEDS:
        short[short.index("--seeds") + 1] = _MORE_SEEDS[words[1]]
    if words[0] == "zenvoy" and words[1] in _WITH_DURATION and "--duration-s" not in words:
        short += ["--duration-s", _SHORTER["--duration-s"]]
    return short


def _commands(line: str) -> Iterator[tuple[str, ...]]:
    words = tuple(shlex.split(line, comments=True))
    while "&&" in words:
        end = words.index("&&")
        yield words[:end]
        words = words[end + 1 :]
    if words:
        yield words
