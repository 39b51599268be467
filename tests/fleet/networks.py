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
    """A host, and its link to the first host: the two addresses, and the names of both ends."""

    name: str
    namespace: str
    server: str
    address: str
    link: str
    far_link: str

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

    def unlink(self) -> None:
        """Remove the link with both of its ends."""
        _run("ip", "-n", self.namespace, "link", "del", self.link)

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
        hosts = [Host(names[0], spaces[0], "127.0.0.1", "127.0.0.1", "lo", "lo")]
        for number, (name, space) in enumerate(zip(names[1:], spaces[1:], strict=True), 1):
            addresses = (f"10.77.{number}.1", f"10.77.{number}.2")
            host = Host(name, space, *addresses, f"zw{number}", f"zv{number}")
            peer = ("peer", "name", host.link, "netns", space)
            _run("ip", "-n", spaces[0], "link", "add", host.far_link, "type", "veth", *peer)
            set_up(hosts[0], host.far_link, host.server)
            set_up(host, host.link, host.address)
            hosts.append(host)
        yield hosts


def set_up(host: Host, link: str, address: str) -> None:
    """Give an end of a link on a host its address."""
    _run("ip", "-n", host.namespace, "addr", "add", f"{address}/24", "dev", link)
    _run("ip", "-n", host.namespace, "link", "set", link, "up")


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
