"""A page and what it shows may end apart: the server, the log, the page, and a vehicle by hand."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from time import monotonic

from playwright.sync_api import expect

from tests.analysis.view.pages import RING, Open, address_in, ready
from tests.conftest import command, wait_until
from zenvoy.analysis.log.load import Run, load


def test_a_page_whose_server_ends_says_so_and_asks_it_seldom(
    open_page: Open, log: Path, tmp_path: Path
) -> None:
    """Between two requests that fail is a pause of a second, however often the page draws."""
    with command(tmp_path, "view", str(log), "--port", "0") as viewer:
        page = ready(open_page(address_in(viewer)))
        viewer.send(signal.SIGINT)
        assert viewer.wait().code == 0
    expect(page.locator("#trouble")).to_have_text("zenvoy view has ended; what is loaded stays.")
    asked: list[float] = []
    page.on("requestfailed", lambda _: asked.append(monotonic()))
    page.keyboard.press("End")  # for which the page needs more of the log
    for _ in range(3):
        page.wait_for_event("requestfailed")
    assert len(asked) <= 1 + (asked[-1] - asked[0]) / 0.9
    page.close()


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
        expect(onlooker.locator("#loss")).to_be_hidden()
        page.locator("#lose").fill("60")  # as a drag of the slider does
        expect(page.locator("#loss output")).to_have_text("60 %")
        expect(page.locator("#events")).to_contain_text("loss: 60 % of all frames besides, by hand")
        second = open_page(f"{address}#{key}")
        expect(second.locator("#loss output")).to_have_text("60 %")
        expect(second.locator("#lose")).to_have_value("60")
        second.locator("#lose").focus()
        for _ in range(5):
            second.keyboard.press("ArrowLeft")
        expect(page.locator("#loss output")).to_have_text("35 %")
        expect(second.locator("#lose")).to_have_value("35")
        second.close()
        page.locator("#kill").click()
        expect(page.locator("#kill")).to_have_text("Kill vehicle 2?")
        page.locator("#kill").click()
        expect(page.locator("#events")).to_contain_text("process lost: vehicle-02")
        times = [float(text.split()[0]) for text in page.locator("#events time").all_inner_texts()]
        assert times == sorted(times)
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 130
        page.close()
        onlooker.close()


def test_a_log_that_is_cut_is_shown_as_unfinished(
    open_page: Open, log: Path, tmp_path: Path
) -> None:
    cut = tmp_path / "cut.mcap"
    content = log.read_bytes()
    cut.write_bytes(content[: 3 * len(content) // 4])
    os.utime(cut, ns=(0, 0))  # nobody has written to it for long
    with command(tmp_path, "view", "cut.mcap", "--port", "0") as viewer:
        page = open_page(address_in(viewer))
        expect(page.locator("#badge")).to_have_text("unfinished")
        expect(page.locator("#trouble")).to_contain_text("has no end, and does not grow")
        expect(page.locator("#live")).to_be_hidden()
        cut.write_bytes(content)  # it goes on after all
        ready(page)
        expect(page.locator("#trouble")).to_be_hidden()
        page.close()


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
