"""docs/api.md has the docstrings of all names that `import zenvoy` offers."""

from __future__ import annotations

import inspect
import re
from functools import cached_property
from typing import Any, Final

import pytest

import zenvoy
from tests.api_page import NAMES, PAGE, page


def _of(name: str) -> Any:
    found: Any = zenvoy
    for part in name.split(".")[1:]:
        found = getattr(found, part)
    return found


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `make docs`"


def test_the_page_has_every_public_name() -> None:
    public = {f"zenvoy.{name}" for name in zenvoy.__all__ if not name.startswith("__")}
    assert public <= set(NAMES)


CLASSES: Final = [name for name in NAMES if inspect.isclass(_of(name))]


@pytest.mark.parametrize("name", CLASSES)
def test_the_page_has_every_attribute(name: str) -> None:
    cls = _of(name)
    found = {
        one for one, value in vars(cls).items() if isinstance(value, property | cached_property)
    }
    wanted = {one for one in (*found, *inspect.get_annotations(cls)) if not one.startswith("_")}
    assert wanted <= set(re.findall(rf"^### `{re.escape(name)}\.(\w+)`$", page(), re.MULTILINE))


def test_nothing_on_the_page_is_explained_by_itself() -> None:
    text = page()
    assert re.findall(r"^.*\b(\w+)\b(?:: .*)? = \1$", text, re.MULTILINE) == []
    assert "default_factory" not in text
    for section in text.split("\n## `zenvoy.")[1:]:
        name = section.partition("`")[0]
        assert f"<code>{name}</code>" not in section.partition("###")[0]
