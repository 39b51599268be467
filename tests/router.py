"""A Zenoh router as a process of its own: `python -m tests.router CONFIG`.

No registry that the tests may use has a package of `zenohd`. A session in the mode "router" is the
same code: `zenohd` parses its options and opens such a session. It ends when its input does.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import zenoh

from tests.as_child import as_child
from tests.fleet.joining import free_ports

ROOT: Final = Path(__file__).parents[1]
# Zenoh says only at its finest level whom access control has refused.
_LOG: Final = "error,zenoh_link_tls=warn,zenoh::net::routing::interceptor::access_control=trace"


@dataclass(frozen=True, slots=True)
class Router:
    """A router that runs, its endpoint, and the file that it writes its log to."""

    endpoint: str
    log: Path


@contextmanager
def router(
    folder: Path, config: Path, endpoint: str, *, tells_refusals: bool = False
) -> Iterator[Router]:
    """Start a router with a configuration, whose paths are relative to its own folder."""
    log = folder / "router.log"
    environment = {
        **os.environ,
        "RUST_LOG": _LOG if tells_refusals else "error",
        "PYTHONPATH": str(ROOT),
    }
    start = as_child(sys.executable, "-m", "tests.router", config.name)
    pipe = subprocess.PIPE
    with (
        log.open("wb") as errors,
        subprocess.Popen(
            start, stdin=pipe, stdout=pipe, stderr=errors, cwd=config.parent, env=environment
        ) as process,
    ):
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == b"listening\n", log.read_text()
            yield Router(endpoint, log)
        finally:
            process.kill()


def locked_endpoint() -> str:
    """Return an endpoint with TLS that no other test gets."""
    return f"tls/127.0.0.1:{free_ports()[0]}"


def main(arguments: Sequence[str]) -> None:
    """Run a router until the end of the input."""
    own = os.dup(1)
    os.dup2(2, 1)  # Zenoh writes its log to file descriptor 1
    zenoh.init_log_from_env_or("error")
    with zenoh.open(zenoh.Config.from_file(arguments[0])):
        os.write(own, b"listening\n")
        sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1:])
