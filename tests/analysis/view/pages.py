"""Helpers find the page that a command serves, and read what it shows."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from playwright.sync_api import Page, expect

from tests.conftest import Command, wait_until

RING: Final = """
duration_s: 20
fleet: {size: 8}
channel: {loss: {p: 0.2}}
events: [{type: brake, vehicle: 3, at_s: 5, duration_s: 2, deceleration_mps2: 3}]
faults: [{type: sensor-blind, vehicles: 6, at_s: 8, duration_s: 3}]
"""
Open = Callable[..., Page]
"""Opens a page."""


def address_in(viewer: Command) -> str:
    """Return the address that a command prints, once it has."""

    def found() -> re.Match[str] | None:
        return re.search(r"http://127\.0\.0\.1:\d+/", viewer.out)

    wait_until(lambda: found() is not None, "the address of the page is printed")
    match = found()
    assert match is not None
    return match[0]


def ready(page: Page) -> Page:
    """Return a page that has read the whole run."""
    expect(page.locator("#badge")).to_have_text("complete")
    expect(page.locator("#tiles dd").nth(2)).not_to_have_text(re.compile("–"))
    return page


def seconds(page: Page) -> float:
    """Return the time that the page shows."""
    return float(page.locator("#time").inner_text().split("/")[0])


def tile(page: Page, number: int) -> float:
    return float(page.locator("#tiles dd span").nth(number).inner_text().replace("−", "-"))


def picture(page: Page, name: str) -> str:
    found: str = page.evaluate("name => document.getElementById(name).toDataURL()", name)
    return found
