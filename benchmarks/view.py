"""`python -m benchmarks.view`: what the page of a run costs, with headless Chromium as its browser.

It measures the processor time that the page's server takes beside a run of 40 vehicles in real
time, and how often a page of 1,000 vehicles is drawn. Chromium draws without a GPU here.
"""

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from playwright.sync_api import Browser, Page, ViewportSize, sync_playwright

from benchmarks.waiting import ends_within

ZENVOY = str(Path(sys.executable).with_name("zenvoy"))
SHOWN_S = 20.0
SIZE: ViewportSize = {"width": 1440, "height": 900}
LOOKED_EVERY_S = 0.1
SETTLES_S = 5.0  # after which the start of the server does not count
FRAMES = "[zenvoyFrames.count, performance.now() / 1000]"


@contextmanager
def showing(*arguments: str) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Run a command that shows a page; yield it and the address of the page."""
    with tempfile.TemporaryFile() as out:
        command = subprocess.Popen([ZENVOY, *arguments], stdout=out, stderr=subprocess.STDOUT)
        try:
            while True:
                found = re.search(rb"http://[\d.:]+/", os.pread(out.fileno(), 10_000, 0))
                if found:
                    break
                if ends_within(command, LOOKED_EVERY_S):
                    sys.exit(os.pread(out.fileno(), 10_000, 0).decode())
            yield command, found[0].decode()
        finally:
            command.send_signal(signal.SIGINT)
            command.wait()


def goes_on(command: subprocess.Popen[bytes], for_s: float) -> None:
    """Let time pass while a command runs; end the benchmark if the command ends meanwhile."""
    if ends_within(command, for_s):
        sys.exit(f"the command has ended with {command.returncode} before its page was measured")


def opened(browser: Browser, address: str, badge: str) -> Page:
    """Return a page once its badge says that it shows the run."""
    page = browser.new_page(viewport=SIZE)
    page.goto(address)
    page.locator("#badge", has_text=badge).wait_for(timeout=300_000)
    return page


def used_s(process: psutil.Process) -> float:
    """Return the processor time that a process has used, s."""
    times = process.cpu_times()
    return float(times.user + times.system)


def server_share(browser: Browser, folder: Path, *, open_page: bool) -> float:
    """Return the share of a core that the server of a page takes, with a page or without."""
    run = ("run", "paper/case-15", "--realtime", "--vehicles-per-process", "10", "--view")
    out = str(folder / f"live-{open_page}")
    with showing(*run, "--duration-s", "120", "--out", out) as (command, address):
        page = opened(browser, address, "live") if open_page else None
        children = psutil.Process(command.pid).children()
        (server,) = (child for child in children if "zenvoy view" in " ".join(child.cmdline()))
        goes_on(command, SETTLES_S)
        before, begun = used_s(server), time.monotonic()
        goes_on(command, SHOWN_S)
        share = (used_s(server) - before) / (time.monotonic() - begun)
        if page is not None:
            page.close()
        return share


def lock_step_s(folder: Path, *, view: bool) -> float:
    """Return the processor time of all processes of a run in lock-step, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = ["run", "paper/case-15", "--duration-s", "60", "--vehicles-per-process", "10"]
    run += ["--out", str(folder / f"lock-step-{view}")]
    if view:
        with showing(*run, "--view") as (command, _):
            log = folder / "lock-step-True" / "summary.json"
            while not log.exists() and not ends_within(command, LOOKED_EVERY_S):
                pass
    else:
        subprocess.run([ZENVOY, *run], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def drawn(browser: Browser, folder: Path) -> tuple[float, float]:
    """Return frames per second of a page of 1,000 vehicles, and simulated time per wall time."""
    out = str(folder / "1000")
    run = ["run", "quickstart", "--set", "fleet.size=1000", "--duration-s", "40"]
    subprocess.run([ZENVOY, *run, "--engine", "arrays", "--out", out], check=True)
    with showing("view", f"{out}/run.mcap", "--port", "0") as (_, address):
        page = opened(browser, address, "complete")
        page.wait_for_timeout(5_000)
        first, since = page.evaluate(FRAMES)
        shown = float(page.locator("#time").inner_text().split("/")[0])
        page.wait_for_timeout(1_000 * SHOWN_S)
        last, until = page.evaluate(FRAMES)
        passed = float(page.locator("#time").inner_text().split("/")[0]) - shown
        page.close()
    return (last - first) / (until - since), passed / (until - since)


def main() -> None:
    """Measure and print."""
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("chromium is not installed; apt-get install chromium")
    print(f"load before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        for view in (False, True):
            spent_s = lock_step_s(folder, view=view)
            print(
                f"case 15 for 60 s in lock-step, --view {view}: {spent_s:.1f} s of processor time"
            )
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for open_page in (False, True):
            share = server_share(browser, folder, open_page=open_page)
            with_page = "with" if open_page else "without"
            print(f"server beside 40 vehicles at 10 Hz, {with_page} a page: {share:.1%} of a core")
        rate, pace = drawn(browser, folder)
        print(f"1,000 vehicles at 1 x: {rate:.0f} frames/s, {pace:.2f} s simulated per s")
        browser.close()


if __name__ == "__main__":
    main()
