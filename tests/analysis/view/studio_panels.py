"""Foxglove Studio itself shows a log and a run with the layout of docs/: `make studio`.

It is version 1.48, the last that npm has, from which Lichtblick descends. It runs from the library
@foxglove/studio-base in headless Chromium. Pictures of it go to runs/studio.
"""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from threading import Thread
from typing import Final
from urllib.parse import quote

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from PIL import Image
from playwright.sync_api import Browser, Locator, Page, expect

from tests.analysis.view.conftest import chromium
from tests.analysis.view.foxglove_client import address_in, wait_for_chunks
from tests.conftest import LIMIT_S, command, wait_until, zenvoy

ROOT: Final = Path(__file__).parents[3]
PICTURES: Final = ROOT / "runs" / "studio"
TOPICS: Final = ("/events", "/fleet/radar", "/fleet/summary", "/fleet/truth", "/scene", "/tf")
FASTEST: Final = (253, 231, 37)
"""The colour of vehicles at the desired speed."""
_ALIKE: Final = 70  # per component, because light and edges change a colour
FIRST_CURVE: Final = (78, 152, 226)
"""The colour in which Studio draws the first curve of a plot."""

# The SDK's servers give the protocol a new name, which clients of today know and this one does not.
# The messages are the same; Lichtblick's pull request 819 adds only the name.
_OLD, _NEW = b"foxglove.websocket.v1", b"foxglove.sdk.v1"


def handler_of(library: Path, files: dict[str, Path]) -> type[SimpleHTTPRequestHandler]:
    """Return what serves Studio's library, the page that starts it, and the opened files."""

    class Files(SimpleHTTPRequestHandler):
        def translate_path(self, path: str) -> str:
            """Return the file of an address."""
            name = path.partition("?")[0].lstrip("/") or "index.html"
            if name in files:
                return str(files[name])
            own = Path(__file__).parent / "studio" / name
            return str(own if own.is_file() else library / name)

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    return Files


@pytest.fixture(scope="module")
def studio(folder: Path) -> Iterator[str]:
    """Return the address of the page."""
    library = Path(os.environ["ZENVOY_STUDIO"])
    shown = ("--duration-s", "20", "--set", "log.scene=true", "--engine", "in-process")
    assert zenvoy(folder, "run", "quickstart", *shown, "--out", "out").code == 0
    script = "@foxglove/studio-base/assets/index.js"
    code = (library / script).read_bytes()
    assert _OLD in code
    (folder / "index.js").write_bytes(code.replace(_OLD, _NEW))
    files = {
        script: folder / "index.js",
        "files/run.mcap": folder / "out" / "run.mcap",
        "files/foxglove-layout.json": ROOT / "docs" / "foxglove-layout.json",
    }
    with ThreadingHTTPServer(("127.0.0.1", 0), handler_of(library, files)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture(scope="module")
def drawing() -> Iterator[Browser]:
    """Return a browser that draws in 3D without a graphics card."""
    with chromium("--use-angle=swiftshader", "--enable-unsafe-swiftshader") as started:
        yield started


@pytest.fixture
def page(drawing: Browser) -> Iterator[Page]:
    page = drawing.new_page(viewport={"width": 1600, "height": 950})
    page.set_default_timeout(LIMIT_S * 1e3)
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    yield page
    page.close()
    assert faults == []


def with_layout(page: Page) -> None:
    """Import the layout of docs/, and return to the topics."""
    page.locator("[data-sidebar-key=layouts]").click()
    page.get_by_label("Import layout").click()
    expect(page.get_by_text("Frames per cycle")).to_be_visible()
    page.get_by_text("Open settings to configure").locator("..").get_by_role("button").click()
    page.locator("[data-sidebar-key=connection]").click()


def check(page: Page, name: str) -> None:
    """Check that every panel shows something and nothing is reported, and take a picture."""
    for topic in TOPICS:
        expect(page.get_by_text(topic, exact=True)).to_be_visible()
    canvases = page.locator("canvas")
    expect(canvases).to_have_count(5)
    road, *plots = canvases.all()
    wait_until(lambda: boxes(road).sum() > 20, "vehicles are drawn")
    for plot in plots:
        wait_until(partial(has_curve, plot), "a curve is drawn")
    problems = page.get_by_role("tab", name="Problems")
    expect(problems).to_have_text("Problems")  # without a number
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png")


def boxes(road: Locator) -> np.ndarray:
    """Return where a pixel and its eight neighbours are yellow: in a vehicle, not in its number."""
    yellow = pixels_of(road, FASTEST)
    return np.asarray(sliding_window_view(yellow, (3, 3)).all(axis=(2, 3)))


def has_curve(plot: Locator) -> bool:
    """Return whether a plot draws its first curve."""
    return bool(pixels_of(plot, FIRST_CURVE).sum() > 20)


def pixels_of(where: Locator, colour: tuple[int, int, int]) -> np.ndarray:
    """Return which of its pixels have about a colour; shape (rows, columns)."""
    with Image.open(BytesIO(where.screenshot())) as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=int)
    return np.asarray(np.abs(pixels - colour).max(axis=2) < _ALIKE)


def test_a_log(studio: str, page: Page) -> None:
    page.goto(studio)
    page.locator("button:has(svg[data-testid=AddIcon])").first.click()
    page.get_by_text("Open local file").click()
    with_layout(page)
    expect(page.get_by_text("0:00:20.000")).to_be_visible()
    check(page, "log")
    road = page.locator("canvas").first
    still = boxes(road)
    page.keyboard.press("Space")
    wait_until(lambda: (boxes(road) != still).sum() > 20, "vehicles move")


def test_a_run_that_goes_on(studio: str, page: Page, tmp_path: Path) -> None:
    """Its plots begin with the run, although it had begun long before."""
    arguments = ("run", "quickstart", "--realtime", "--duration-s", "600", "--out", "shown")
    with command(tmp_path, *arguments, "--foxglove") as shown:
        address = quote(address_in(shown), safe="")
        wait_for_chunks(tmp_path / "shown" / "run.mcap")
        page.goto(f"{studio}?ds=foxglove-websocket&ds.url={address}")
        with_layout(page)
        expect(page.get_by_text(re.compile("12:00:00.000 AM GMT")).first).to_be_visible()
        expect(page.get_by_text(re.compile("Hz"))).to_have_count(5)
        check(page, "live")
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 130
