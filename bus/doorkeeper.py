"""Reports whom Zenoh has refused: it reads the log that Zenoh writes to standard output."""

from __future__ import annotations

import os
import re
import threading
from typing import Final

import zenoh

from zenvoy.bus.access import SERVERS
from zenvoy.bus.refusals import Refusals
from zenvoy.bus.topics import TOPICS, alive_key

NO_CERTIFICATE: Final = "connection"  # not let in at all
UNAUTHORIZED: Final = "unauthorized"  # let in, but not allowed to use this key

# Zenoh says only at its finest level whom access control has refused.
_FILTER: Final = "error,zenoh_link_tls=warn,zenoh::net::routing::interceptor::access_control=trace"
_COLOURS: Final = re.compile(r"\x1b\[[0-9;]*m")
_THREAD: Final = re.compile(r" (ThreadId\(\d+\)) ")
_LINK: Final = re.compile(
    r" zenoh_link_tls::\w+: (?P<why>.*?)(: verification time .*|\. Hint: .*)?$"
)
_STRANGER: Final = " did not match any configured ACL subject"
_CACHING: Final = re.compile(r"ACL \((?P<flow>\w+)\): caching permissions for `(?P<key>.*)` ")
_VERDICT: Final = re.compile(
    r"CertCommonName\((?P<who>.*?)\).* is (?P<un>un)?authorized to .* "
    r"\((?P<flow>ingress|egress)\) on (?P<key>.*)$"
)
_MOST_REPORTED: Final = 200  # kinds of refusals; the others are only counted
_ACTIONS: Final = 9  # kinds of messages on which Zenoh decides for a key that is new to it


class Doorman:
    """Understands the lines of Zenoh's log, and counts who was refused.

    When a session first names a key, Zenoh decides in advance about all kinds of messages on it,
    and says so in a block of lines. Only a key on which the session may do nothing counts. Zenoh
    also decides so about the keys of this process itself, when a session connects; these do not.
    """

    def __init__(self, run: str, refusals: Refusals) -> None:
        self._prefix = f"zenvoy/{run}/"
        fixed = [topic.key(run) for topic in TOPICS if topic.pattern and not topic.per_vehicle]
        self._fixed = {*fixed, *(alive_key(run, role) for role in SERVERS)}
        self._refusals = refusals
        self._blocks: dict[str, tuple[int, int]] = {}  # by thread: lines to come, denials so far

    def read(self, line: str) -> None:
        """Take a line of the log."""
        text = _COLOURS.sub("", line)
        if link := _LINK.search(text):
            self._refusals.add(NO_CERTIFICATE, link["why"])
        elif _STRANGER in text:
            self._refusals.add(NO_CERTIFICATE, "a certificate that is not in the list")
        elif found := _THREAD.search(text):
            self._decided(found[1], text)

    def _decided(self, thread: str, text: str) -> None:
        if _CACHING.search(text):
            self._blocks[thread] = (_ACTIONS, 0)
            return
        verdict = _VERDICT.search(text)
        left, denials = self._blocks.get(thread, (0, 0))
        denied = verdict is not None and verdict["un"] is not None
        if left:
            left, denials = left - 1, denials + denied
            self._blocks[thread] = (left, denials)
            denied = left == 0 and denials == _ACTIONS
            if verdict is not None and verdict["key"] in self._fixed:
                return
        if verdict is None or not denied or verdict["flow"] != "ingress":
            return
        if self._prefix.startswith(f"{verdict['key']}/"):
            return  # Zenoh gives a number to the common beginning of keys, too
        self._refusals.add(UNAUTHORIZED, f"{verdict['key']} by {verdict['who']}")


class Doorkeeper:
    """Passes Zenoh's log to a doorman, from a thread of its own, as long as the process lives.

    Zenoh writes to file descriptor 1, which the processes of a fleet do not use otherwise.
    """

    def __init__(self, name: str, run: str) -> None:
        self.refusals = Refusals(name, most=_MOST_REPORTED)
        if "RUST_LOG" in os.environ:  # the user wants to read Zenoh's log itself
            zenoh.init_log_from_env_or(_FILTER)
            return
        self._doorman = Doorman(run, self.refusals)
        reader, writer = os.pipe()
        os.dup2(writer, 1)
        os.close(writer)
        zenoh.init_log_from_env_or(_FILTER)
        threading.Thread(target=self._read, args=(reader,), daemon=True).start()

    def _read(self, reader: int) -> None:
        with open(reader, encoding="utf-8", errors="replace") as lines:
            for line in lines:
                self._doorman.read(line.rstrip("\n"))
