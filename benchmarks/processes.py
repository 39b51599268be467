"""Runs the processes of one measurement: it forks them together and leaves none behind."""

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkProcess

PR_SET_PDEATHSIG = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """The pipes by which a process of a measurement talks to its parent."""

    result: Connection
    gate: Connection

    def report(self, rate: float) -> None:
        """Send the measured rate, 1/s, to the parent; exactly one of the processes does this."""
        self.result.send(rate)

    def wait_for_end(self) -> None:
        """Block until the parent has the rate, so that no process leaves while others need it."""
        wait([self.gate])


Job = Callable[[Control], None]


def measure(jobs: Mapping[str, Job], limit_s: float) -> float:
    """Run each of `jobs` in a process of its own, and return the rate, 1/s, that one reports.

    Raises RuntimeError if a process fails, and TimeoutError if they are not all done within
    `limit_s`. No process outlives the call.
    """
    context = multiprocessing.get_context("fork")
    deadline = time.monotonic() + limit_s
    with ExitStack() as stack:
        result, result_of_child = map(stack.enter_context, context.Pipe(duplex=False))
        gate_of_child, gate = map(stack.enter_context, context.Pipe(duplex=False))
        control = Control(result=result_of_child, gate=gate_of_child)
        processes = [
            context.Process(target=_run, name=name, args=(job, control, gate))
            for name, job in jobs.items()
        ]
        stack.callback(_kill, processes)
        for process in processes:
            process.start()
        rate = _rate(processes, result, deadline)
        gate.close()
        _join(processes, deadline)
        return rate


def _run(job: Job, control: Control, gate: Connection) -> None:
    """Run the job in a child, which closes its copy of the gate so that only one is left."""
    gate.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C and ends its children
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if parent is None or os.getppid() != parent.pid:  # it died before the line above
        sys.exit(1)
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    job(control)


def _rate(processes: Sequence[ForkProcess], result: Connection, deadline: float) -> float:
    """Wait for the reported rate; raises if a process fails before."""
    running = {process.sentinel: process for process in processes}
    while True:
        ready = wait([result, *running], max(0.0, deadline - time.monotonic()))
        if not ready:
            raise TimeoutError(f"no result in time from {len(processes)} processes")
        _check([running.pop(item) for item in ready if isinstance(item, int)])
        if result in ready:
            return float(result.recv())
        if not running:
            raise RuntimeError("all processes have ended, and none has reported a rate")


def _join(processes: Sequence[ForkProcess], deadline: float) -> None:
    for process in processes:
        process.join(max(0.0, deadline - time.monotonic()))
        if process.is_alive():
            raise TimeoutError(f"{process.name} did not end in time")
    _check(processes)


def _check(ended: Sequence[ForkProcess]) -> None:
    for process in ended:
        process.join()
        if process.exitcode != 0:
            raise RuntimeError(f"{process.name} ended with exit code {process.exitcode}")


def _kill(processes: Sequence[ForkProcess]) -> None:
    for process in processes:
        if process.pid is not None:
            process.kill()
            process.join()
