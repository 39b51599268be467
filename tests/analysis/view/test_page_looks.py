"""The page can be read on every screen, in light and dark, and has the colours of the report."""

from __future__ import annotations

from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from playwright.sync_api import expect

from tests.analysis.view.pages import Open, picture, ready
from tests.conftest import wait_until


@pytest.mark.parametrize(("width", "height"), [(400, 800), (1280, 800), (3840, 2160)])
def test_the_page_fits_screens_of_every_size(open_page: Open, width: int, height: int) -> None:
    page = ready(open_page(width=width, height=height))
    size = page.evaluate("[document.documentElement.scrollWidth, document.body.scrollHeight]")
    assert size[0] <= width
    assert width < 900 or size[1] <= height
    small = page.evaluate(
        """() => [...document.querySelectorAll("body *")]
            .filter((one) => one.checkVisibility() && one.textContent.trim())
            .filter((one) => parseFloat(getComputedStyle(one).fontSize) < 9).length"""
    )
    assert small == 0
    for name in ("road", "lens", "spacetime", "channel"):
        box = page.locator(f"canvas#{name}").bounding_box()
        assert box is not None
        assert box["width"] > 0.3 * width
        assert box["height"] > 60
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
    assert page.locator("#charts canvas").count() == 2


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1366, 650), (1440, 900)])
@pytest.mark.parametrize("road", ["ring", "open"])
def test_nothing_is_cut_on_a_low_screen(
    open_page: Open, width: int, height: int, road: str
) -> None:
    page = ready(open_page(width=width, height=height))
    page.evaluate("isOpen => document.body.classList.toggle('open', isOpen)", road == "open")
    for name in ("road", "lens", "spacetime", "channel", "events"):
        outside = page.evaluate(
            """name => {
                const part = document.getElementById(name).getBoundingClientRect();
                const panel = document.getElementById(name).parentElement.getBoundingClientRect();
                return part.bottom - panel.bottom;
            }""",
            name,
        )
        assert outside <= 0, name
    assert page.locator("#events").evaluate("one => one.clientHeight") > 80  # four rows


def luminance(colour: str) -> float:
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark_can_be_read(open_page: Open, scheme: str) -> None:
    page = ready(open_page(color_scheme=scheme))
    assert page.evaluate("document.documentElement.dataset.theme") == scheme
    names = ["panel", "text", "quiet", "warn", "truth", "estimate", "reading", "lost", "late"]
    colours = page.evaluate(
        """names => Object.fromEntries(names.map((name) => [name,
            getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()]))""",
        names,
    )
    panel = colours.pop("panel")
    for name, colour in colours.items():
        least = 4.5 if name in {"text", "quiet", "warn"} else 2.5  # lines need less than words
        assert contrast(panel, colour) >= least, name
    shown = picture(page, "road")
    page.keyboard.press("t")
    assert page.evaluate("document.documentElement.dataset.theme") != scheme
    expect(page.locator("#road")).to_be_visible()
    wait_until(lambda: picture(page, "road") != shown, "the road is drawn in other colours")


def test_colours_are_those_of_matplotlib(open_page: Open) -> None:
    page = open_page()
    found = page.evaluate("import('./colours.js').then((module) => module.cividis)")
    expected = 255 * mpl.colormaps["cividis"](np.linspace(0, 1, len(found)))[:, :3]
    assert np.abs(np.array(found) - expected).max() < 12  # of 255
    brightness = np.array(found) @ [0.2126, 0.7152, 0.0722]
    assert all(low < high for low, high in pairwise(brightness))  # also without any colour
