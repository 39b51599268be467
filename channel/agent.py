"""The channel under either clock: it sends the frames of a cycle and decides their outcomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.checks import fault_in_beacon, fault_in_positions
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.packed import PackedCodec, encode_bytes
from zenvoy.bus.topics import LINKS, POSITIONS, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.channel.beacons import BeaconReader
from zenvoy.channel.delivery import Air
from zenvoy.channel.faulty_transmitters import FaultyTransmitters
from zenvoy.channel.sent import Sent
from zenvoy.channel.transmission import Transmission, Transmitted
from zenvoy.links.sent_frames import Scene
from zenvoy.scenarios import Scenario

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)
_LINKS: Final = FlatEncoder(pb.Links.DESCRIPTOR, leave_out=("frames", "late_host", "late_ns"))


class Channel:
    """The channel of a scenario, and the frames in flight (`air`).

    `lock_step` and `realtime` decide when it transmits the frames of a cycle and when `air`
    delivers them.
    """

    def __init__(self, scenario: Scenario, shared: Sequence[VehicleProcess] = ()) -> None:
        """Take the scenario, and the processes that run several vehicles."""
        self._size = scenario.fleet.size
        self._period_ns = scenario.period_ns
        self._ring_length_m = scenario.ring_length_m
        self._transmitters = FaultyTransmitters(scenario)
        self._transmission = Transmission(scenario)
        self.air = Air(self._size, shared)
        self.beacon_reader: Final = BeaconReader(scenario.period_ns)
        """Reads the beacons of shared processes."""

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None.

        Positions and beacons must have the time at which their cycle starts. Positions must cover
        the whole fleet.
        """
        start_ns = message.cycle * self._period_ns
        if topic is POSITIONS:
            return fault_in_positions(message, self._size, start_ns)
        return fault_in_beacon(message, vehicle, start_ns)

    @property
    def least_latency_ns(self) -> int:
        """The least time from sending a frame to its arrival."""
        return self._transmission.least_latency_ns

    def transmit(self, positions: pb.Positions, beacons: Mapping[int, Sent]) -> Envelope:
        """Put the frames of a cycle on the air, and return their outcomes for the log.

        beacons: those of one cycle that have arrived, by vehicle. A vehicle whose beacon is
        missing, or says that it is silent, sends nothing.
        """
        speaking = {vehicle: sent for vehicle, sent in beacons.items() if not sent.silent}
        on_air = self._transmitters.sent(speaking, positions.time_ns)
        senders = [vehicle - 1 for vehicle in on_air]
        speaks = np.zeros(self._size, dtype=np.bool_)
        speaks[senders] = True
        sequence = np.zeros(self._size, dtype=np.int64)
        sequence[senders] = [sent.sequence for sent in on_air.values()]
        position = np.array(positions.position)
        scene = Scene(positions.cycle, positions.time_ns, position, self._ring_length_m)
        transmitted = self._transmission.of(speaks, sequence, scene, positions.loss_by_hand)
        frames, outcomes = transmitted.frames, transmitted.outcomes
        payloads = {vehicle: sent.payload for vehicle, sent in on_air.items()}
        self.air.send(payloads, frames.source, frames.destination, outcomes.arrived_ns)
        return _links(scene, transmitted)


def _links(scene: Scene, sent: Transmitted) -> Envelope:
    frames = frame_table(scene, sent)
    head = _LINKS.encode(cycle=scene.cycle, time_ns=scene.sent_ns)
    return Envelope(LINKS, 0, head + encode_bytes(pb.Links.FRAMES_FIELD_NUMBER, frames))


def frame_table(scene: Scene, sent: Transmitted) -> bytes:
    """Return the table of the frames of a cycle as it is logged: a serialized pb.Frames."""
    frames, outcomes = sent.frames, sent.outcomes
    return _FRAMES.encode(
        cycle=scene.cycle,
        time_ns=scene.sent_ns,
        source=frames.source + 1,
        destination=frames.destination + 1,
        sequence=frames.sequence,
        sent_ns=np.full(len(frames.source), scene.sent_ns),
        arrived_ns=outcomes.arrived_ns,
        latency_ns=outcomes.latency_ns,
        distance=frames.distance,
        outcome=outcomes.outcome,
        **({} if sent.busy_ratio is None else {"busy_ratio": sent.busy_ratio}),
        **({} if sent.hops is None else {"hops": sent.hops}),
    )
