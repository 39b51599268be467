"""Helpers read HTML pages, and check what must hold for every page."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Final

VOID: Final = {"meta", "img", "br", "hr", "link", "input"}


@dataclass
class Read(HTMLParser):
    """The content of a page. Reading fails on tags that are not closed in order."""

    open: list[str] = field(default_factory=list)
    tags: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    text: dict[str, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len(attrs) == len(dict(attrs)), f"<{tag}> has an attribute twice"
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.text.setdefault(self.open[-1], []).append(data)

    def all(self, name: str, attribute: str) -> list[str]:
        """Return the values of an attribute of all tags of one name, or of any for "*"."""
        found = [a.get(attribute) for tag, a in self.tags if name in {tag, "*"}]
        return [value for value in found if value is not None]

    def texts(self, tag: str) -> list[str]:
        """Return the texts directly inside tags of one name."""
        return [text.strip() for text in self.text.get(tag, []) if text.strip()]


def read(html: str) -> Read:
    """Parse a page, and check what holds for every page."""
    page = Read()
    page.feed(html)
    page.close()
    assert page.open == []
    ids = page.all("*", "id")
    assert len(ids) == len(set(ids))
    targets = [*page.all("*", "href"), *("#" + name for name in page.all("*", "aria-labelledby"))]
    assert {target.removeprefix("#") for target in targets} <= set(ids)
    assert all(source.startswith("data:image/") for source in page.all("*", "src"))
    assert not {tag for tag, _ in page.tags} & {"script", "link", "iframe", "object", "base"}
    assert "url(" not in html
    assert "@import" not in html
    assert all(page.all("img", "alt"))
    return page
