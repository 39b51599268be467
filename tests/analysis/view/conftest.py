"""Pages of a run in headless Chromium, driven by Playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.analysis.view.pages import RING, Open, address_in
from tests.conftest import LIMIT_S, command
from tests.logs import write_log
from zenvoy.analysis.log.load import Run, load

CHROMIUM: Final = shutil.which("chromium") or shutil.which("chromium-browser")
_LIMIT_MS: Final = LIMIT_S * 1e3
expect.set_options(timeout=_LIMIT_MS)


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
    with chromium() as started:
        yield started


@contextmanager
def chromium(*arguments: str) -> Iterator[Browser]:
    """Start a browser for a while. Skips the test where there is none."""
    if CHROMIUM is None:  # it is no package of Python; .ci/run installs it where apt can
        pytest.skip("chromium is not installed; apt-get install chromium")
    with sync_playwright() as playwright:
        sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=[*sandbox, *arguments])
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
