"""Serves the page of a run on this machine."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from tornado.httpserver import HTTPServer
from tornado.web import Application, HTTPError, RequestHandler, StaticFileHandler

from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.controls import NO_CONTROLS, Controls
from zenvoy.analysis.view.doors import refusal
from zenvoy.analysis.view.watched import WatchedRun

_PAUSE_S: Final = 0.1  # between looks at a log that has not grown
_TURN_S: Final = 0.01
_TURNS: Final = 20  # for which reading on waits for pages, at most
_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


async def serve(
    path: Path, made: socket.socket, until: asyncio.Event, controls: Controls = NO_CONTROLS
) -> None:
    """Serve the page of the run logged at `path` until an event is set.

    The log may not exist yet. Raises LogError for a file that is not the log of a run.
    """
    run = WatchedRun(path)
    with ThreadPoolExecutor(1, "reader") as reader:  # one thread, because a run may have only one
        asked = _Asked()
        server = HTTPServer(_application(run, reader, asked, controls))
        server.add_socket(made)
        reading = asyncio.create_task(_follow(run, path, reader, asked))
        ending = asyncio.create_task(until.wait())
        try:
            done, _ = await asyncio.wait({reading, ending}, return_when=asyncio.FIRST_COMPLETED)
            if reading in done:
                await reading  # so that an error of it ends the server
            await ending
        finally:
            server.stop()
            reading.cancel()
            ending.cancel()
            await server.close_all_connections()


@dataclass
class _Asked:
    """How many questions of pages wait for an answer."""

    waiting: int = 0


async def _follow(run: WatchedRun, path: Path, reader: ThreadPoolExecutor, asked: _Asked) -> None:
    """Read the log until its end, or for as long as it may grow, while no page waits."""
    loop = asyncio.get_running_loop()
    while not (run.begun and run.whole):
        for _ in range(_TURNS):
            if not asked.waiting:
                break
            await asyncio.sleep(_TURN_S)
        more = path.exists() and await loop.run_in_executor(reader, run.extend)
        await asyncio.sleep(0 if more else _PAUSE_S)


def _application(
    run: WatchedRun, reader: ThreadPoolExecutor, asked: _Asked, controls: Controls
) -> Application:
    given = {"run": run, "reader": reader, "asked": asked, "controls": controls}
    page = str(files("zenvoy.analysis.view") / "page")
    return Application(
        [
            *((f"/{name}", handler, given) for name, handler in _HANDLERS.items()),
            ("/acts", _Acts, given),
            (r"/(.*)", _Page, {"path": page, "default_filename": "index.html"}),
        ],
        log_function=lambda _: None,
    )


class _Guarded(RequestHandler):
    """A handler that answers only to its own page."""

    def prepare(self) -> None:
        why = refusal(self.request.headers)
        if why is not None:
            self.set_status(403)
            self.finish(why)

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Print errors of this program, but no requests that are refused."""
        if not isinstance(error, HTTPError):
            super().log_exception(kind, error, trace)

    def set_default_headers(self) -> None:
        for name, value in _HEADERS.items():
            self.set_header(name, value)


class _Page(_Guarded, StaticFileHandler):
    """The files of the page."""

    def set_extra_headers(self, path: str) -> None:
        self.set_header("Cache-Control", "no-cache")


class _OfRun(_Guarded):
    """A handler that asks the run, in the thread that may use it."""

    def initialize(
        self, run: WatchedRun, reader: ThreadPoolExecutor, asked: _Asked, controls: Controls
    ) -> None:
        """Take what the application gives."""
        self._run = run
        self._asked = asked
        self._controls = controls
        self._reader = reader

    async def ask(self, question: Callable[..., Any], *arguments: Any) -> Any:
        """Return an answer of the run."""
        loop = asyncio.get_running_loop()
        self._asked.waiting += 1
        try:
            return await loop.run_in_executor(self._reader, question, *arguments)
        except LogError as error:
            raise HTTPError(503, reason="the log cannot be read", log_message=str(error)) from error
        finally:
            self._asked.waiting -= 1

    def number(self, name: str, default: int) -> int:
        """Return an argument that is a whole number of 0 or more."""
        text = self.get_query_argument(name, str(default))
        if not (text.isascii() and text.isdigit() and len(text) < 12):
            raise HTTPError(400)
        return int(text)

    def numbers(self, name: str) -> Sequence[int]:
        """Return an argument that is a list of whole numbers, with commas between."""
        text = self.get_query_argument(name, "")
        if not text.replace(",", "").isdigit():
            return ()
        return [int(part) for part in text.split(",") if part and len(part) < 6]

    async def answer(self, question: Callable[..., Any], *arguments: Any) -> None:
        """Answer with bytes, or with values as JSON."""
        found = await self.ask(question, *arguments)
        if isinstance(found, bytes):
            self.set_header("Content-Type", "application/octet-stream")
            self.finish(found)
        else:
            self.set_header("Content-Type", "application/json; charset=utf-8")
            self.finish(json.dumps(found))


class _About(_OfRun):
    async def get(self) -> None:
        await self.answer(self._run.about)


class _State(_OfRun):
    async def get(self) -> None:
        await self.answer(self._run.state, self.number("events", 0))


class _Acts(_OfRun):
    """What may be done to the run, and the doing of it."""

    def get(self) -> None:
        self.finish({"acts": list(self._controls.acts)})

    async def post(self) -> None:
        act = self.get_query_argument("act", "")
        why = self._controls.refusal(self.request.headers.get("X-Zenvoy-Key", ""), act)
        if why is not None:
            self.set_status(403)
            self.finish(why)
            return
        wanted = self._controls.acts[act]
        number = self.number(wanted.of, -1)
        if number not in wanted.allowed:
            raise HTTPError(400)
        about = await self.ask(self._run.about)
        if not wanted.do(number, about["run"]):
            self.set_status(409)
            self.finish(f"{act} {wanted.of} {number}: its process is not here any more")


class _Cycles(_OfRun):
    async def get(self) -> None:
        first, last = self.number("from", 0), self.number("to", 0)
        step = max(1, self.number("step", 1))
        await self.answer(self._run.cycles, first, last, step, self.numbers("vehicles"))


class _Links(_OfRun):
    async def get(self) -> None:
        first, last = self.number("from", 0), self.number("to", 0)
        await self.answer(self._run.links, first, last, self.numbers("vehicles"))


class _Overview(_OfRun):
    async def get(self) -> None:
        await self.answer(self._run.overview, self.number("from", 0))


_HANDLERS: Final[dict[str, type[_OfRun]]] = {
    "about": _About,
    "state": _State,
    "cycles": _Cycles,
    "links": _Links,
    "overview": _Overview,
}
