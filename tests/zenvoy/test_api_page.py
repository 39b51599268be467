"""docs/api.md has the docstrings of all names that `import zenvoy` offers."""

from __future__ import annotations

import zenvoy
from tests.api_page import NAMES, PAGE, page


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `make docs`"


def test_the_page_has_every_public_name() -> None:
    public = {f"zenvoy.{name}" for name in zenvoy.__all__ if not name.startswith("__")}
    assert public <= set(NAMES)
