"""The bare Zenoh barrier: the processes, links and messages of Zenvoy's cycle, without its work.

The difference from Zenvoy's own rate is the cost of its agents, protobuf and log. The flow of a
cycle:

    sense    world -> vehicle      beacon   vehicle -> channel     positions  world -> channel
    receive  channel -> vehicle    command  vehicle -> world       links      channel -> world

Without lookahead, the world begins a cycle when it has all commands of the cycle before. With a
lookahead it begins that many cycles earlier, as Zenvoy does if commands take effect later.

A vehicle has a subscriber for each of its two streams. With one subscriber on `vehicle/<id>/*` the
rate was the same for 10 vehicles and a sixth lower for 40.
"""

import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self

from benchmarks.processes import Control, Job, measure
from benchmarks.tuned_zenoh import (
    MESSAGE_LIMIT_BYTES,
    announce,
    await_announced,
    open_session,
    publisher,
    subscribe,
)

WARM_UP_CYCLES = 20
START_LIMIT_S = 60.0
CYCLE_LIMIT_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Payload bytes of each message; `links` is the sum over its messages in a cycle."""

    sense: int = 66
    beacon: int = 91
    positions: int = 337
    receive: int = 4_120
    command: int = 205
    links: int = 68_680

    @classmethod
    def of_fleet(cls, vehicles: int) -> Self:
        """Return the sizes of Zenvoy's messages for a ring, IEEE 802.11p, gaps of 37.5 m.

        A frame has 105 bytes in `receive` and 44 in `links`, for each vehicle within 1 km.
        """
        in_range = min(vehicles - 1, 2 * int(1_000 / 37.5))
        return cls(
            positions=17 + 8 * vehicles,
            receive=25 + 105 * in_range,
            links=40 + 44 * vehicles * in_range,
        )

    def links_payloads(self) -> list[bytes]:
        """Return the links of a cycle in as few messages of equal size as the transport allows."""
        messages = max(1, -(-self.links // MESSAGE_LIMIT_BYTES))
        return [bytes(-(-self.links // messages))] * messages


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """The settings that all processes of a measurement share."""

    world: str
    channel: str
    vehicles: int
    cycles: int
    sizes: Sizes
    lookahead: int

    @property
    def ids(self) -> range:
        return range(1, self.vehicles + 1)

    @property
    def names(self) -> list[str]:
        return [f"vehicle-{i}" for i in self.ids]


def bare_barrier(vehicles: int, cycles: int, sizes: Sizes, lookahead: int = 0) -> float:
    """Return the world's cycles per second of wall time, over `cycles` after the warm-up."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-bare-") as folder:
        run = Run(
            world=f"unixsock-stream/{Path(folder, 'world')}",
            channel=f"unixsock-stream/{Path(folder, 'channel')}",
            vehicles=vehicles,
            cycles=WARM_UP_CYCLES + cycles,
            sizes=sizes,
            lookahead=lookahead,
        )
        jobs: dict[str, Job] = {"world": partial(_world, run), "channel": partial(_channel, run)}
        jobs |= {f"vehicle-{i}": partial(_vehicle, run, i) for i in run.ids}
        return measure(jobs, START_LIMIT_S + run.cycles * CYCLE_LIMIT_S)


def _world(run: Run, control: Control) -> None:
    sense, position = bytes(run.sizes.sense), bytes(run.sizes.positions)
    links_messages = len(run.sizes.links_payloads())
    with open_session([run.world], []) as session:
        commands = subscribe(session, "vehicle/*/command")
        links = subscribe(session, "channel/links")
        senses = [publisher(session, f"vehicle/{i}/sense") for i in run.ids]
        positions = publisher(session, "world/positions")
        await_announced(session, [*run.names, "channel"])
        start_ns = 0
        for cycle in range(run.cycles):
            if cycle == WARM_UP_CYCLES:
                start_ns = time.perf_counter_ns()
            for vehicle in senses:
                vehicle.put(sense)
            positions.put(position)
            if cycle < run.lookahead:
                continue
            for _ in run.ids:
                commands.recv()
            for _ in range(links_messages):
                links.recv()
        elapsed_s = (time.perf_counter_ns() - start_ns) * 1e-9
        control.report((run.cycles - WARM_UP_CYCLES) / elapsed_s)
        control.wait_for_end()


def _channel(run: Run, control: Control) -> None:
    receive, links_payloads = bytes(run.sizes.receive), run.sizes.links_payloads()
    with open_session([run.channel], [run.world]) as session:
        beacons = subscribe(session, "vehicle/*/beacon")
        positions = subscribe(session, "world/positions")
        receives = [publisher(session, f"vehicle/{i}/receive") for i in run.ids]
        links = publisher(session, "channel/links")
        await_announced(session, run.names)
        with announce(session, "channel"):
            for _ in range(run.cycles):
                positions.recv()
                for _ in run.ids:
                    beacons.recv()
                for vehicle in receives:
                    vehicle.put(receive)
                for payload in links_payloads:
                    links.put(payload)
            control.wait_for_end()


def _vehicle(run: Run, i: int, control: Control) -> None:
    beacon, command = bytes(run.sizes.beacon), bytes(run.sizes.command)
    with open_session([], [run.world, run.channel]) as session:
        senses = subscribe(session, f"vehicle/{i}/sense")
        receives = subscribe(session, f"vehicle/{i}/receive")
        beacons = publisher(session, f"vehicle/{i}/beacon")
        commands = publisher(session, f"vehicle/{i}/command")
        with announce(session, f"vehicle-{i}"):
            for _ in range(run.cycles):
                senses.recv()
                beacons.put(beacon)
                receives.recv()
                commands.put(command)
            control.wait_for_end()
