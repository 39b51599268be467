"""Runs a scenario on one of the buses, in a folder of its own."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType

from zenvoy.analysis.log.cells import utf8
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Agent
from zenvoy.bus.clock import stamp, wall_ns
from zenvoy.bus.hosts import hosts
from zenvoy.bus.in_process import InProcessBus
from zenvoy.channel.agent import ChannelAgent
from zenvoy.cli.ends import Death
from zenvoy.cli.fleet import clock_to, process_table
from zenvoy.cli.guests import FILE, NO_GUESTS, Guests, meeting
from zenvoy.cli.limits import require_room_for
from zenvoy.cli.progress import RunProgress
from zenvoy.cli.sockets import socket_folder
from zenvoy.cli.supervisor import Supervisor
from zenvoy.cli.terminal import requests_to_end_handled_by
from zenvoy.scenarios import Loaded, MultiNode, Scenario, effective_json, roster
from zenvoy.vehicles.agent import VehicleAgent
from zenvoy.vehicles.knowledge import prepare
from zenvoy.world.agent import WorldAgent
from zenvoy.world.recorder import Labels, Recorder


class FolderError(Exception):
    """The folder for a run cannot be made, or holds one already."""


class Interrupted(KeyboardInterrupt):
    """The command was asked to end; `complete` says whether its run was over by then."""

    def __init__(self, *, complete: bool) -> None:
        super().__init__()
        self.complete = complete

    def __str__(self) -> str:
        kept = "the run was complete by then" if self.complete else "the log up to here is kept"
        return f"interrupted; {kept}"


def make_folder(out: Path | None, name: str) -> Path:
    """Folder for a run, new or empty; raises FolderError."""
    base = Path("runs") / f"{stamp()}-{name.replace('/', '-')}"
    folder = base if out is None else out
    number = 1
    while out is None and folder.exists():
        number += 1
        folder = base.with_name(f"{base.name}-{number}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FolderError(f"--out {folder}: is not empty; name a new folder or an empty one")
        (folder / "logs").mkdir()
    except OSError as error:
        raise FolderError(f"--out {folder}: {error.strerror}") from error
    return folder


def labels_of(loaded: Loaded, bus: str, per_process: int) -> Labels:
    """What the log will say of this run."""
    scenario = loaded.scenario
    return Labels(
        scenario_name=utf8(loaded.name).decode(),  # that of a file may be no text
        scenario_text=loaded.text,
        effective_json=effective_json(scenario),
        seed=scenario.seed,
        cycles=scenario.cycles,
        period_ns=scenario.period_ns,
        vehicles=scenario.fleet.size,
        bus=bus,
        run=f"{stamp()}-{os.getpid()}",
        per_process=per_process,
        # Without their places: a log does not tell whose machine it was made on.
        notes=tuple(utf8(str(replace(note, place=None))).decode() for note in loaded.notes),
    )


def run_in_process(loaded: Loaded, folder: Path, progress: RunProgress) -> None:
    """Run the whole fleet in this process, without Zenoh."""
    scenario = loaded.scenario
    with Recorder(
        folder / "run.mcap", labels_of(loaded, "in-process", loaded.scenario.fleet.size), wall_ns
    ) as recorder:
        recorder.on_clock = _seldom(progress)
        vehicles = range(1, scenario.fleet.size + 1)
        agents: list[Agent] = [
            WorldAgent(scenario),
            ChannelAgent(scenario),
            *(VehicleAgent(scenario, vehicle) for vehicle in vehicles),
        ]
        recorder.start_clock()
        try:
            with _interrupted_between(recorder):
                InProcessBus(agents, recorder.log).run()
        except KeyboardInterrupt:
            recorder.end = "stopped"
            raise Interrupted(complete=False) from None


def run_on_zenoh(
    loaded: Loaded,
    folder: Path,
    progress: RunProgress,
    on_loss: Callable[[Death], None] = lambda _: None,
    guests: Guests = NO_GUESTS,
    per_process: int = 1,
) -> Death | None:
    """Run world, channel and vehicles as processes; the untimely death that ended it, if any.

    Its code is 0 where who died had done its part, and the run is complete. `per_process` vehicles
    share a process. Raises OSError where the system has no room for the run, and Interrupted.

    In real time the run goes on without a vehicle: its death is told to `on_loss`. While it runs,
    its folder says where `guests` and others connect to.
    """
    size = loaded.scenario.fleet.size
    require_room_for(len(hosts(size, per_process, guests.without)) + 2)
    sockets = socket_folder()  # paths of sockets are short by law, those of runs are not
    labels = labels_of(loaded, "zenoh", per_process)
    met = meeting(labels.run, sockets, guests.listen)
    _rehearse(loaded.scenario)
    read_fd, write_fd = os.pipe()
    supervisor: Supervisor | None = None
    try:
        table = process_table(
            loaded.scenario,
            labels,
            folder / "run.mcap",
            sockets,
            clock_to(write_fd),
            met,
            guests.without,
            per_process,
        )
        met.write(folder)
        supervisor = Supervisor(table, folder / "logs", loaded.scenario.stall_limit_s)
        with supervisor:
            death = supervisor.watch(read_fd, progress.feed, on_loss)
        return death._replace(code=0) if death and supervisor.completed else death
    except KeyboardInterrupt:
        complete = supervisor is not None and supervisor.completed
        raise Interrupted(complete=complete) from None
    finally:
        os.close(read_fd)
        os.close(write_fd)
        (folder / FILE).unlink(missing_ok=True)  # nobody listens there any more
        shutil.rmtree(sockets, ignore_errors=True)


def _rehearse(scenario: Scenario) -> None:
    """Do once, before the fork, what every process would do for itself.

    Gains are computed, and a few cycles of a small fleet make the interpreter specialise its
    bytecode: afterwards the processes share the result instead of each writing a copy.
    """
    prepare(scenario)
    # The model that most of the fleet ends up with; what is said of single vehicles does not apply.
    models = Counter(told.phases[-1][1] for told in roster(scenario))
    control = scenario.control.model_copy(
        update={"model": models.most_common(1)[0][0], "schedule": (), "multi_node": MultiNode()}
    )
    size = 2 * control.multi_node.neighbours + 1
    changes = {
        "control": control,
        "fleet": scenario.fleet.model_copy(update={"size": size, "groups": ()}),
        "events": (),
        "duration_s": 64 * scenario.period_ns * 1e-9,
    }
    small = scenario.model_copy(update=changes)
    agents: list[Agent] = [WorldAgent(small), ChannelAgent(small)]
    agents += [VehicleAgent(small, vehicle) for vehicle in range(1, size + 1)]
    InProcessBus(agents, lambda *_: None).run()


@contextmanager
def _interrupted_between(recorder: Recorder) -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP end the run between two messages of the log, not within one.

    Raises KeyboardInterrupt out of the recorder's `on_clock`.
    """
    asked = False
    show = recorder.on_clock

    def ask(_signal: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked = True

    def tick(clock: pb.Clock) -> None:
        show(clock)
        if asked:
            raise KeyboardInterrupt

    recorder.on_clock = tick
    with requests_to_end_handled_by(ask):
        yield


def _seldom(progress: RunProgress) -> Callable[[pb.Clock], None]:
    """Shows one clock message in ten, so that showing costs nothing."""
    return lambda clock: progress.show(clock) if clock.cycle % 10 == 0 else None
