"""HELICS for comparison: value federates in lock-step, each in a process of its own.

A federate publishes one double per step of 0.1 s and reads that of its neighbour, in a ring. That
is less work than a cycle of Zenvoy, which has four messages per vehicle and a barrier for all.

The settings favour speed: period 0.1 s, uninterruptible (no grants between steps), no wait for the
current time's updates (in a ring it would deadlock), no logging, batch scheduling as for Zenvoy,
and the default distributed timing (--globaltime took three times as long). `zmq` is the usual core
between processes; `ipc`, shared memory on one machine, is the fastest.
"""

import multiprocessing
import os
import random
import socket
import time
from contextlib import ExitStack
from functools import partial
from multiprocessing.synchronize import Event

import helics

from benchmarks.processes import Control, Job, measure

STEP_S = 0.1
WARM_UP_STEPS = 20
START_LIMIT_S = 60.0
STEP_LIMIT_S = 0.5
# These ports are below the range that Linux uses for outgoing connections. The broker gives the
# ports above its own to the federates unchecked, and the run fails if one has been taken since.
PORTS = range(10_000, 30_000)


def helics_steps(federates: int, steps: int, core: str = "zmq") -> float:
    """Return the first federate's steps per second of wall time, over `steps` after the warm-up.

    `core` is `zmq` or `ipc`. Raises TimeoutError if the federation hangs, RuntimeError if a
    federate fails or reads a value of another step.
    """
    if core == "zmq":
        port = _free_ports(federates + 10)
        here, there = f"--port={port}", f"--brokerport={port}"
    else:
        name = f"zenvoy_bare_{os.getpid()}"
        here, there = f"--local_interface={name}", f"--broker_address={name}"
    ready = multiprocessing.get_context("fork").Event()
    last = WARM_UP_STEPS + steps
    jobs: dict[str, Job] = {"broker": partial(_broker, ready, federates, core, here)}
    for i in range(federates):
        neighbour = (i - 1) % federates
        jobs[f"federate-{i}"] = partial(_federate, ready, core, there, i, neighbour, last)
    return measure(jobs, START_LIMIT_S + last * STEP_LIMIT_S)


def _free_ports(count: int) -> int:
    """Return the first of `count` consecutive free ports on the loopback interface."""
    while True:
        first = random.choice(PORTS)
        with ExitStack() as stack:
            try:
                for port in range(first, first + count):
                    stack.enter_context(socket.socket()).bind(("127.0.0.1", port))
            except OSError:
                continue
            return first


def _broker(ready: Event, federates: int, core: str, address: str, control: Control) -> None:
    options = f"--federates={federates} --loglevel=no_print {address}"
    broker = helics.helicsCreateBroker(core, "", options)
    if not helics.helicsBrokerIsConnected(broker):
        raise RuntimeError("the HELICS broker could not start")
    ready.set()  # a core that starts before its broker may lose 20 s in retries
    helics.helicsBrokerWaitForDisconnect(broker, -1)
    control.wait_for_end()
    helics.helicsBrokerFree(broker)
    helics.helicsCloseLibrary()


def _federate(
    ready: Event, core: str, broker: str, i: int, neighbour: int, last: int, control: Control
) -> None:
    ready.wait()
    federate = helics.helicsCreateValueFederate(f"federate-{i}", _settings(core, broker))
    output = helics.helicsFederateRegisterPublication(federate, "x", helics.HELICS_DATA_TYPE_DOUBLE)
    value = helics.helicsFederateRegisterSubscription(federate, f"federate-{neighbour}/x")
    helics.helicsFederateEnterExecutingMode(federate)
    start_ns = 0
    for step in range(1, last + 1):
        if step == WARM_UP_STEPS + 1:
            start_ns = time.perf_counter_ns()
        helics.helicsPublicationPublishDouble(output, float(step))
        helics.helicsFederateRequestTime(federate, step * STEP_S)
        if helics.helicsInputGetDouble(value) != step:
            raise RuntimeError(f"federate {i} read a value of another step in step {step}")
    elapsed_s = (time.perf_counter_ns() - start_ns) * 1e-9
    if i == 0:
        control.report((last - WARM_UP_STEPS) / elapsed_s)
    helics.helicsFederateDisconnect(federate)
    helics.helicsFederateFree(federate)
    helics.helicsCloseLibrary()


def _settings(core: str, broker: str) -> helics.HelicsFederateInfo:
    info = helics.helicsCreateFederateInfo()
    helics.helicsFederateInfoSetCoreTypeFromString(info, core)
    options = f"--federates=1 --loglevel=no_print {broker}"
    helics.helicsFederateInfoSetCoreInitString(info, options)
    helics.helicsFederateInfoSetTimeProperty(info, helics.HELICS_PROPERTY_TIME_PERIOD, STEP_S)
    flags = helics.HelicsFederateFlag
    helics.helicsFederateInfoSetFlagOption(info, flags.UNINTERRUPTIBLE, True)
    helics.helicsFederateInfoSetFlagOption(info, flags.WAIT_FOR_CURRENT_TIME_UPDATE, False)
    helics.helicsFederateInfoSetIntegerProperty(
        info, helics.HELICS_PROPERTY_INT_LOG_LEVEL, helics.HELICS_LOG_LEVEL_NO_PRINT
    )
    return info
