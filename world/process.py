"""The world process: its agent on the Zenoh bus, with the recorder beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.clock import wall_ns
from zenvoy.bus.errors import StoppedError
from zenvoy.bus.topics import CLOCK, EVENTS, scenario_key
from zenvoy.bus.zenoh_bus import Wiring, ZenohBus, answer
from zenvoy.scenarios import Scenario
from zenvoy.world.agent import WorldAgent
from zenvoy.world.recorder import Labels, Recorder


def run_world(
    scenario: Scenario,
    labels: Labels,
    path: Path,
    wiring: Wiring,
    on_clock: Callable[[pb.Clock], None],
) -> None:
    """Integrate and log to the end of the run, or until asked to end; raises BusError.

    However it ends, the log at `path` is ended properly and says how.
    """
    with Recorder(path, labels, wall_ns) as recorder:
        bus = ZenohBus(WorldAgent(scenario), wiring, recorder.log)

        def tick(clock: pb.Clock) -> None:
            bus.publish(CLOCK, clock.SerializeToString())
            on_clock(clock)

        recorder.on_clock = tick
        effective = labels.effective_json.encode()
        try:
            with bus, answer(bus.session, scenario_key(wiring.run), lambda: effective):
                recorder.start_clock()
                try:
                    bus.run()
                except StoppedError:  # while the session is open: it knows who is gone
                    _end(recorder, bus.lost_processes())
                recorder.close()  # closing the session may wait for a peer that is frozen
        except StoppedError:  # before the first cycle
            _end(recorder, [])


def _end(recorder: Recorder, lost: list[str]) -> None:
    """Write the last words of a run that was asked to end."""
    recorder.end = "stopped"
    time_ns = recorder.time_ns
    events = [pb.Event(time_ns=time_ns, kind=pb.EVENT_PROCESS_LOST, text=name) for name in lost]
    events.append(pb.Event(time_ns=time_ns, kind=pb.EVENT_STOPPED, text="asked to end"))
    for event in events:
        recorder.log(EVENTS, time_ns, event.SerializeToString())
