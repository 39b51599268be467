"""A link between two hosts that delays and drops packets, where the kernel has no `tc netem`.

Each end is a TUN device. A thread reads the packets that leave by one end, waits, and writes those
that are not lost to the other.
"""

from __future__ import annotations

import fcntl
import os
import random
import struct
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from heapq import heappop, heappush
from itertools import count
from select import select
from threading import Thread
from time import monotonic
from typing import Final

import pytest

from tests.fleet.networks import Host, set_up

_TUN: Final = "/dev/net/tun"
_SET_INTERFACE: Final = 0x4004_54CA  # TUNSETIFF
_PLAIN_PACKETS: Final = 0x1001  # IFF_TUN | IFF_NO_PI
_LONGEST: Final = 65_536
_LOOK_S: Final = 0.1  # between looks for the end of the link


class Relay:
    """Carries packets between two devices."""

    def __init__(self, devices: tuple[int, int], delay_s: float, loss: float) -> None:
        self._devices = devices
        self._delay_s = delay_s
        self._loss = loss
        self._random = random.Random(1)
        self._open = True
        self.carried = 0
        self.lost = 0

    def run(self) -> None:
        """Carry packets until `end`."""
        one, other = self._devices
        onward = {one: other, other: one}
        order = count()
        under_way: list[tuple[float, int, int, bytes]] = []
        while self._open:
            wait_s = min(_LOOK_S, max(0.0, under_way[0][0] - monotonic()) if under_way else _LOOK_S)
            for device in select(self._devices, (), (), wait_s)[0]:
                packet = os.read(device, _LONGEST)
                if self._random.random() < self._loss:
                    self.lost += 1
                else:
                    due = monotonic() + self._delay_s
                    heappush(under_way, (due, next(order), onward[device], packet))
            while under_way and under_way[0][0] <= monotonic():
                _, _, device, packet = heappop(under_way)
                with suppress(OSError):  # the link has been cut meanwhile
                    os.write(device, packet)
                    self.carried += 1

    def end(self) -> None:
        """Let `run` return."""
        self._open = False


@contextmanager
def relayed(first: Host, host: Host, *, delay_s: float, loss: float) -> Iterator[Relay]:
    """Replace the link of a host with one that delays each packet, and loses this share of them.

    Skips the test, with the reason, where no TUN device can be opened.
    """
    with ExitStack() as stack:
        try:
            os.close(os.open(_TUN, os.O_RDWR))
        except OSError as error:
            pytest.skip(f"no TUN devices here: {error}")
        host.unlink()
        one = stack.enter_context(_end(first, host.far_link, host.server))
        other = stack.enter_context(_end(host, host.link, host.address))
        relay = Relay((one, other), delay_s, loss)
        carrying = Thread(target=relay.run)
        carrying.start()
        stack.callback(carrying.join)
        stack.callback(relay.end)
        yield relay


@contextmanager
def _end(host: Host, link: str, address: str) -> Iterator[int]:
    """Make an end of the link on a host, and yield its device."""
    with host.inside():  # a device belongs to the namespace where it was opened
        device = os.open(_TUN, os.O_RDWR)
    try:
        fcntl.ioctl(device, _SET_INTERFACE, struct.pack("16sH", link.encode(), _PLAIN_PACKETS))
        set_up(host, link, address)
        yield device
    finally:
        os.close(device)
