"""Hosts with addresses of their own, in network namespaces that a test makes."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Final

import pytest

_CLONE_NEWNET: Final = 0x4000_0000
_LIBC: Final = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True, slots=True)
class Host:
    """A host, the address of the first host on its link, and the name of its end of the link."""

    name: str
    namespace: str
    server: str
    link: str

    def shape(self, *netem: str) -> None:
        """Delay or drop the packets that leave by the link, as `tc netem` says."""
        device = ("qdisc", "replace", "dev", self.link, "root", "netem")
        _run("ip", "netns", "exec", self.namespace, "tc", *device, *netem)

    def cut(self) -> None:
        """Cut the link."""
        _run("ip", "-n", self.namespace, "link", "set", self.link, "down")

    def heal(self) -> None:
        """Mend the link."""
        _run("ip", "-n", self.namespace, "link", "set", self.link, "up")

    @contextmanager
    def inside(self) -> Iterator[None]:
        """Start commands on this host: they inherit the namespace of this thread."""
        here = os.open("/proc/thread-self/ns/net", os.O_RDONLY)
        there = os.open(f"/run/netns/{self.namespace}", os.O_RDONLY)
        try:
            _enter(there)
            yield
        finally:
            _enter(here)
            os.close(here)
            os.close(there)


@contextmanager
def star(names: Sequence[str]) -> Iterator[list[Host]]:
    """Yield a first host, and one per further name that is linked to it; skip where none can be.

    The link of host k has the addresses 10.77.k.1 and 10.77.k.2.
    """
    _require()
    with ExitStack() as stack:
        spaces = [f"zt{os.getpid()}{name}" for name in names]
        for space in spaces:
            _run("ip", "netns", "add", space)
            stack.callback(_run, "ip", "netns", "del", space)
            _run("ip", "-n", space, "link", "set", "lo", "up")
        hosts = [Host(names[0], spaces[0], "127.0.0.1", "lo")]
        for number, (name, space) in enumerate(zip(names[1:], spaces[1:], strict=True), 1):
            ends = (f"zv{number}", f"zw{number}")
            peer = ("peer", "name", ends[1], "netns", space)
            _run("ip", "-n", spaces[0], "link", "add", ends[0], "type", "veth", *peer)
            for where, end, last in ((spaces[0], ends[0], 1), (space, ends[1], 2)):
                _run("ip", "-n", where, "addr", "add", f"10.77.{number}.{last}/24", "dev", end)
                _run("ip", "-n", where, "link", "set", end, "up")
            hosts.append(Host(name, space, f"10.77.{number}.1", ends[1]))
        yield hosts


def _require() -> None:
    """Skip the test, with the reason, where this user cannot make namespaces and links."""
    if os.geteuid() != 0:
        pytest.skip("network namespaces need root")
    for program in ("ip", "tc"):
        if shutil.which(program) is None:
            pytest.skip(f"network namespaces need {program} (iproute2)")
    probe = f"zt{os.getpid()}probe"
    add = ("ip", "netns", "add", probe)
    tried = subprocess.run(add, check=False, capture_output=True, text=True)
    if tried.returncode:
        pytest.skip(f"no network namespaces here: {tried.stderr.strip()}")
    _run("ip", "netns", "del", probe)


def require_netem(host: Host) -> None:
    """Skip the test where the kernel cannot delay and drop packets."""
    netem = ("tc", "qdisc", "replace", "dev", host.link, "root", "netem", "delay", "1ms")
    inside = ("ip", "netns", "exec", host.namespace, *netem)
    tried = subprocess.run(inside, check=False, capture_output=True, text=True)
    if tried.returncode:
        pytest.skip(f"no tc netem here: {tried.stderr.strip()}")


def _run(*command: str) -> None:
    subprocess.run(command, check=True)


def _enter(namespace: int) -> None:
    if _LIBC.setns(namespace, _CLONE_NEWNET):
        raise OSError(ctypes.get_errno(), "setns")
