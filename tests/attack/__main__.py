"""A fleet of processes includes an attacker, which sends mutated messages to all the others.

    python -m tests.attack SCENARIO.yaml OUT MUTANTS_PER_CYCLE VEHICLES_PER_PROCESS

Vehicles listen nowhere, and peers do not relay, so here vehicles also connect to the attacker. It
receives all messages. In each cycle it sends random bytes and mutants of real messages. It never
sends a message that could pass for a real one: without keys, nobody can distinguish a whole body of
the present cycle with a true head.
"""

from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

from tests.attack.attacker import attack
from tests.attack.turns import Turns
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.ends import Death
from zenvoy.fleet.folder import make_folder
from zenvoy.fleet.guests import endpoints_of
from zenvoy.fleet.labels import labels_of
from zenvoy.fleet.spawn import Program
from zenvoy.fleet.supervisor import Supervisor
from zenvoy.fleet.table import process_table
from zenvoy.scenarios import load
from zenvoy.vehicles.process import run_vehicle, run_vehicles


def main(scenario: Path, out: Path, per_cycle: int, per_process: int) -> list[Death]:
    """Run the scenario under attack, and return the deaths of processes."""
    loaded = load(scenario)
    folder = make_folder(out, loaded.name)
    labels = labels_of(loaded, "zenoh", per_process)
    deaths: list[Death] = []
    realtime = loaded.scenario.clock == "realtime"
    turns = Turns(realtime=realtime)
    with tempfile.TemporaryDirectory(prefix="zt-") as sockets:
        met = endpoints_of(labels.run, Path(sockets), ())
        table = process_table(
            loaded.scenario,
            labels,
            folder / "run.mcap",
            Path(sockets),
            turns.take,
            met,
            per_process=per_process,
            on_arrival=lambda *_: None,
            on_held_up=lambda _: None,
        )
        here = f"unixsock-stream/{sockets}/attacker"
        size = loaded.scenario.fleet.size
        shared = [process for process in vehicle_processes(size, per_process) if process.is_shared]
        links = here, list(met.connect)
        attacker = Program(
            name="attacker",
            run=labels.run,
            main=partial(attack, labels.run, size, shared, links, per_cycle, realtime, turns),
            essential=False,
        )
        programs = [*(_within_reach(program, here) for program in table), attacker]
        read_fd, write_fd = os.pipe()
        with Supervisor(programs, folder / "logs", loaded.scenario.stall_limit_s) as supervisor:
            death = supervisor.watch(read_fd, lambda _: True, deaths.append)
        os.close(read_fd)
        os.close(write_fd)
    return deaths if death is None else [*deaths, death]


def _within_reach(program: Program, attacker: str) -> Program:
    """Return the program, with a link to the attacker if it is a vehicle's."""
    main = program.main
    assert isinstance(main, partial)
    if main.func not in {run_vehicle, run_vehicles}:
        return program
    scenario, which, wiring = main.args
    linked = replace(wiring, connect=(*wiring.connect, attacker))
    return replace(program, main=partial(main.func, scenario, which, linked))


if __name__ == "__main__":
    ended = main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
    for one in ended:
        print(one, *one.tail, sep="\n", file=sys.stderr)
    sys.exit(bool(ended))
