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
        with bus:
            effective = labels.effective_json.encode()
            with answer(bus.session, scenario_key(wiring.run), lambda: effective):
                recorder.start_clock()
                try:
                    bus.run()
                except StoppedError:
                    recorder.end = "stopped"
                    for event in _last_words(recorder.time_ns, bus.lost_processes()):
                        recorder.log(EVENTS, recorder.time_ns, event.SerializeToString())


def _last_words(time_ns: int, lost: list[str]) -> list[pb.Event]:
    words = [pb.Event(time_ns=time_ns, kind=pb.EVENT_PROCESS_LOST, text=name) for name in lost]
    return [*words, pb.Event(time_ns=time_ns, kind=pb.EVENT_STOPPED, text="asked to end")]
