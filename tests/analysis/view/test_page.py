"""The page in a real browser: headless Chromium, driven by Playwright."""

from __future__ import annotations

import os
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.analysis.view.pages import address_in
from tests.conftest import LIMIT_S, command, wait_until
from tests.logs import write_log
from zenvoy.analysis.log.load import Run, load
from zenvoy.links.distance import gaps

CHROMIUM: Final = shutil.which("chromium") or shutil.which("chromium-browser")
# A browser is no package of Python, so a fresh machine may have none; .ci/run installs it.
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="chromium is not installed; apt-get install chromium"
)
RING: Final = """
duration_s: 20
fleet: {size: 8}
channel: {loss: {p: 0.2}}
events: [{type: brake, vehicle: 3, at_s: 5, duration_s: 2, deceleration_mps2: 3}]
faults: [{type: sensor-blind, vehicles: 6, at_s: 8, duration_s: 3}]
"""
_LIMIT_MS: Final = LIMIT_S * 1e3
expect.set_options(timeout=_LIMIT_MS)

Open = Callable[..., Page]


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    return write_log(folder / "ring.mcap", RING)


@pytest.fixture(scope="module")
def run(log: Path) -> Run:
    return load(log)


@pytest.fixture(scope="module")
def address(log: Path, folder: Path) -> Iterator[str]:
    with command(folder, "view", str(log), "--port", "0") as viewer:
        yield address_in(viewer)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=sandbox)
        yield started
        started.close()


@pytest.fixture
def open_page(browser: Browser, address: str) -> Iterator[Open]:
    """Return a function that opens a page; none may have an error, or ask another server."""
    faults: list[str] = []
    contexts = []

    def open_it(at: str = address, width: int = 1280, height: int = 800, **options: Any) -> Page:
        options.setdefault("reduced_motion", "reduce")  # so that it does not play by itself
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(_LIMIT_MS)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on(
            "request",
            lambda ask: (
                None if ask.url.startswith(at.partition("#")[0]) else faults.append(ask.url)
            ),
        )
        page.goto(at)
        return page

    yield open_it
    for context in contexts:
        context.close()
    assert faults == []


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


def test_vehicles_move_and_figures_are_those_of_the_log(open_page: Open, run: Run) -> None:
    page = ready(open_page())
    assert seconds(page) == 0.0
    before = picture(page, "road")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_attribute("aria-label", re.compile("Pause"))
    wait_until(lambda: seconds(page) > 0.5, "the page has played for half a second")
    page.keyboard.press("Space")
    assert picture(page, "road") != before
    page.keyboard.press("Home")
    for _ in range(7):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#time")).to_have_text("7.0 / 20.0 s")
    gap = float(np.nanmin(gaps(run.truth["position"][70], run.scenario.ring_length_m)))
    expect(page.locator("#tiles dd span").nth(2)).to_have_text(f"{gap:.2f}")
    assert tile(page, 1) == pytest.approx(run.truth["speed"][70].mean(), abs=0.006)
    expect(page.locator("#events .now")).to_contain_text("vehicle 3 stops braking")
    expect(page.locator("#lens-title")).to_have_text("Around vehicle 3")


def test_a_fault_is_seen_and_the_mouse_finds_vehicles(open_page: Open) -> None:
    page = ready(open_page())
    expect(page.locator("#faulty")).to_be_hidden()
    page.locator("#events button", has_text="vehicle 6 fault:").click()
    expect(page.locator("#time")).to_have_text("8.0 / 20.0 s")
    expect(page.locator("#faulty")).to_be_visible()
    expect(page.locator("#lens-title")).to_have_text("Around vehicle 6")
    page.locator("#events button", has_text="vehicle 6 fault over").click()
    expect(page.locator("#faulty")).to_be_hidden()
    box = page.locator("#road").bounding_box()
    assert box is not None
    found = set()
    radius = min(box["width"], box["height"]) / 2 - 32  # within a vehicle's reach of the ring
    for part in range(60):
        angle = 2 * np.pi * part / 60
        x = box["x"] + box["width"] / 2 + radius * np.cos(angle)
        y = box["y"] + box["height"] / 2 + radius * np.sin(angle)
        page.mouse.move(x, y)
        page.evaluate("() => new Promise(requestAnimationFrame)")
        page.evaluate("() => new Promise(requestAnimationFrame)")
        if page.locator("#hover").is_visible():
            name = page.locator("#hover").inner_text().split(" · ")[0]
            if name not in found:
                found.add(name)
                page.mouse.click(x, y)
                expect(page.locator("#lens-title")).to_have_text(f"Around {name}")
    assert found == {f"vehicle {number}" for number in range(1, 9)}


def test_keys_do_what_they_say(open_page: Open) -> None:
    page = ready(open_page())
    press = page.keyboard.press
    for key, time in [
        ("End", 20.0),
        ("ArrowLeft", 19.0),
        ("Shift+ArrowLeft", 9.0),
        (".", 9.1),
        (",", 9.0),
        ("Home", 0.0),
    ]:
        press(key)
        expect(page.locator("#time")).to_have_text(f"{time:.1f} / 20.0 s")
    press("+")
    expect(page.locator("#speed")).to_have_value("2")
    press("-")
    press("-")
    expect(page.locator("#speed")).to_have_value("0.5")
    press("]")
    expect(page.locator("#lens-title")).to_have_text("Around vehicle 4")
    press("[")
    press("[")
    expect(page.locator("#lens-title")).to_have_text("Around vehicle 2")
    press("c")
    expect(page.locator("#colour")).to_have_value("mode")
    expect(page.locator("#legend")).to_contain_text("PBCM")
    press("r")
    expect(page.locator("#radio")).to_have_value("hears")
    press("?")
    expect(page.locator("#keys")).to_be_visible()
    press("Escape")
    expect(page.locator("#keys")).to_be_hidden()
    page.locator("#number").fill("6")
    press("Enter")
    expect(page.locator("#charts figure")).to_have_count(2)
    page.get_by_label("Remove vehicle 2").click()
    expect(page.locator("#vehicles-title")).to_have_text("Vehicle 6")
    page.locator("#scrubber").focus()
    press("ArrowRight")
    expect(page.locator("#time")).to_have_text("1.0 / 20.0 s")
    page.locator("#play").focus()
    press("Space")  # the button itself, once
    expect(page.locator("#play")).to_have_attribute("aria-label", re.compile("Pause"))


def test_every_control_has_a_name_and_a_visible_focus(open_page: Open) -> None:
    page = ready(open_page())
    seen = set()
    for _ in range(40):
        page.keyboard.press("Tab")
        found = page.evaluate(
            """() => {
                const one = document.activeElement;
                const style = getComputedStyle(one);
                const name = one.getAttribute("aria-label") || one.textContent.trim()
                    || (one.labels && one.labels[0] && one.labels[0].textContent.trim());
                const width = parseFloat(style.outlineWidth);
                return [one.id || one.tagName, name, style.outlineStyle, width];
            }"""
        )
        if found[0] in {"BODY", "HTML"}:
            break
        seen.add(found[0])
        assert found[1], found
        assert found[2] != "none", found
        assert found[3] >= 2, found
    assert {"colour", "radio", "upwards", "number", "scrubber", "play", "speed", "theme"} <= seen


def test_two_pages_at_once_have_times_of_their_own(open_page: Open) -> None:
    one, other = ready(open_page()), ready(open_page())
    one.keyboard.press("End")
    other.keyboard.press("ArrowRight")
    expect(one.locator("#time")).to_have_text("20.0 / 20.0 s")
    expect(other.locator("#time")).to_have_text("1.0 / 20.0 s")
    one.close()
    other.keyboard.press("ArrowRight")
    expect(other.locator("#time")).to_have_text("2.0 / 20.0 s")
    expect(other.locator("#trouble")).to_be_hidden()


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


def test_a_click_brakes_a_vehicle_of_a_run_in_real_time(open_page: Open, tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("{duration_s: 600, clock: realtime, fleet: {size: 4}}")
    with command(tmp_path, "run", "s.yaml", "--out", "out", "--view") as shown:
        address = address_in(shown)
        key = shown.out.partition("/#")[2].split()[0]
        page = open_page(f"{address}#{key}")
        onlooker = open_page(address)
        expect(page.locator("#badge")).to_have_text("live")
        expect(page.locator("#time")).to_have_text(re.compile(r"^[1-9]"))  # it follows the run
        page.locator("#brake").click()
        braked = re.compile("vehicle 2 brakes, 3 m/s², by hand")
        expect(page.locator("#events")).to_contain_text(braked)
        expect(onlooker.locator("#events")).to_contain_text(braked)
        expect(onlooker.locator("#brake")).to_be_hidden()
        page.locator("#kill").click()
        expect(page.locator("#kill")).to_have_text("Kill vehicle 2?")
        page.locator("#kill").click()
        expect(page.locator("#events")).to_contain_text("process lost: vehicle-02")
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 130
        page.close()
        onlooker.close()


def test_a_page_that_is_closed_harms_no_run(open_page: Open, tmp_path: Path, run: Run) -> None:
    (tmp_path / "s.yaml").write_text(RING)
    arguments = ("run", "s.yaml", "--engine", "in-process", "--out", "out", "--view")
    with command(tmp_path, *arguments) as shown:
        address = address_in(shown)
        first = open_page(address)
        second = open_page(address)
        first.close()  # at whatever moment of the run
        wait_until(lambda: "the page stays" in shown.out, "the run has ended")
        ready(second).keyboard.press("End")
        expect(second.locator("#time")).to_have_text("20.0 / 20.0 s")
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 0
        second.close()
    assert load(tmp_path / "out" / "run.mcap").fingerprint == run.fingerprint
