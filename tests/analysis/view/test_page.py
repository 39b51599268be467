"""The page in a real browser shows the run, does what its keys say, and harms nothing."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.analysis.view.pages import Open, address_in, picture, ready, seconds, tile
from tests.conftest import command, wait_until
from tests.logs import write_log
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.links.distance import gaps

LOST = (pb.OUTCOME_LOST, pb.OUTCOME_COLLIDED, pb.OUTCOME_CORRUPTED)


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
    page.locator("#events button", has_text="vehicle 6 has a fault:").click()
    expect(page.locator("#time")).to_have_text("8.0 / 20.0 s")
    expect(page.locator("#faulty")).to_be_visible()
    expect(page.locator("#lens-title")).to_have_text("Around vehicle 6")
    page.locator("#events button", has_text="vehicle 6 no longer has the fault").click()
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


def test_lost_frames_are_counted_after_a_jump_as_after_steps(open_page: Open, run: Run) -> None:
    page = ready(open_page())
    page.locator("#events button", has_text="vehicle 6 has a fault:").click()
    expect(page.locator("#time")).to_have_text("8.0 / 20.0 s")
    cycle = np.round(run.frames["sent_ns"] / run.scenario.period_ns)
    recent = run.frames["outcome"][(cycle >= 60) & (cycle <= 80)]
    share = 100 * np.isin(recent, LOST).mean()
    at = page.locator("#tiles dt").all_inner_texts().index("Frames lost")
    expect(page.locator("#tiles dd").nth(at)).to_contain_text(f"{share:.1f}")


def test_keys_that_change_the_vehicle_keep_the_others(open_page: Open) -> None:
    page = ready(open_page())
    vehicle = int(page.locator("#lens-title").inner_text().rpartition(" ")[2])
    page.locator("#number").fill(str(vehicle % 8 + 1))  # the one that ] would come to
    page.locator("#choose button").click()
    expect(page.locator("#vehicles-title")).to_have_text("Chosen vehicles")
    page.keyboard.press("]")
    expect(page.locator("#lens-title")).to_have_text(f"Around vehicle {(vehicle + 1) % 8 + 1}")
    expect(page.locator("#vehicles-title")).to_have_text("Chosen vehicles")  # still two


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


def test_a_click_leaves_the_keys_as_they_were(open_page: Open) -> None:
    page = ready(open_page())
    page.locator("#theme").click()
    theme = page.evaluate("document.documentElement.dataset.theme")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_attribute("aria-label", re.compile("Pause"))
    assert page.evaluate("document.documentElement.dataset.theme") == theme
    page.locator("#help").click()
    page.locator("#keys button").click()  # the dialog gives the focus back to what opened it
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_attribute("aria-label", re.compile("Play"))
    expect(page.locator("#keys")).to_be_hidden()
    page.keyboard.press("Space")
    page.locator("#events button", has_text="vehicle 6 has a fault").click()
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_attribute("aria-label", re.compile("Play"))


def test_a_frame_has_the_same_line_in_every_legend(open_page: Open) -> None:
    page = ready(open_page())
    lines = page.evaluate(
        """() => ["radio-legend", "channel-legend"].map((legend) => Object.fromEntries(
            [...document.getElementById(legend).querySelectorAll("svg")].map((svg) =>
                [svg.classList[1], svg.firstChild.getAttribute("stroke-dasharray")])))"""
    )
    assert lines[0].keys() == {"delivered", "late", "lost", "collided"}
    assert len(set(lines[0].values())) == 4
    assert {"lost"} <= lines[1].keys()
    assert {name: lines[0][name] for name in lines[1]} == lines[1]


def test_two_directions_between_a_pair_are_two_arcs(open_page: Open) -> None:
    page = ready(open_page())
    page.locator("#radio").select_option("neighbours")
    page.evaluate("""async () => {
        const { drawRoad } = await import("./road.js");
        const { Surface } = await import("./canvas.js");
        const surface = new Surface(document.getElementById("road"), { isDark: false });
        const positions = Float64Array.from({ length: 8 }, (_, i) => 300 - 37.5 * i);
        const about = { ring: 300, length: 5 };
        const scene = { positions, size: 8, speeds: positions };
        const view = { colour: "speed", scale: { low: 0, high: 1 }, chosen: [], faulty: [] };
        const depth = (place, p, q) => {
            const [x, y] = place.control(p, q);
            const [a, b] = place.at((p + q) / 2);
            return Math.hypot(x - a, y - b);
        };
        window.depths = [about, { ...about, ring: null }].map((road) => {
            const place = drawRoad(surface, { ...scene, about: road }, view);
            return [depth(place, 100, 137.5), depth(place, 137.5, 100)];
        });
    }""")
    for ahead, behind in page.evaluate("window.depths"):  # ring and open road
        assert ahead > 1.5 * behind > 0


def test_vehicles_without_data_are_in_the_legend(open_page: Open, tmp_path: Path) -> None:
    deaf = "{duration_s: 2, fleet: {size: 4}, control: {model: BCM}, channel: {loss: {p: 1}}}"
    log = write_log(tmp_path / "deaf.mcap", deaf)
    with command(tmp_path, "view", str(log), "--port", "0") as viewer:
        page = ready(open_page(address_in(viewer)))
        expect(page.locator("#legend")).not_to_contain_text("no data")
        page.locator("#colour").select_option("age")
        expect(page.locator("#legend")).to_contain_text("no data")
        page.close()


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
