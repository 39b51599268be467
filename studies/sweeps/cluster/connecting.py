"""Connects to the scheduler of a Dask cluster, or says in one line why that is impossible."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final
from warnings import catch_warnings, filterwarnings

from distributed import Client
from distributed.core import rpc
from distributed.utils import LoopRunner, sync

from zenvoy.scenarios import Spelling
from zenvoy.studies.sweeps.cluster.versions import PACKAGES, difference, versions_here
from zenvoy.studies.sweeps.errors import NoClusterError
from zenvoy.studies.sweeps.plan import counted

LIMIT_S: Final = 10.0

_CLOSE_LIMIT_S: Final = 5.0
_LOGGER: Final = "distributed"


@contextmanager
def client_of(address: str, spelling: Spelling) -> Iterator[Client]:
    """Yield a client of the scheduler at an address, whose workers have this process's versions.

    Dask's own log is silent in the meantime. Raises NoClusterError.
    """
    dask = spelling.option("dask", address)
    with _silent():
        _require_scheduler(address, dask)
        client = Client(address, timeout=LIMIT_S, set_as_default=False)
        try:
            if unlike := unlike_workers(client):
                others = counted(len(unlike) - 1, "other worker")
                more = f" (and {others})" if unlike[1:] else ""
                raise NoClusterError(f"{dask}: {unlike[0]}{more}")
            yield client
        finally:
            client.close(timeout=_CLOSE_LIMIT_S)


def unlike_workers(client: Client) -> list[str]:
    """Return a line for each worker with other versions than this process."""
    versions: Any = client.get_versions(packages=list(PACKAGES))
    lines = (
        difference(worker, _of_dask(of_worker["packages"]), versions_here())
        for worker, of_worker in versions["workers"].items()
    )
    return [line for line in lines if line is not None]


def _of_dask(packages: Mapping[str, str | None]) -> dict[str, str | None]:
    """Return the versions as Dask reports them: that of Python has five parts."""
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {name: packages.get(name) for name in PACKAGES} | {"python": python}


def _require_scheduler(address: str, dask: str) -> None:
    """Raise NoClusterError unless a scheduler answers. A client that finds none closes slowly.

    Errors name the address as `dask`.
    """
    runner = LoopRunner()
    runner.start()
    try:
        identity = sync(runner.loop, _identity, address, callback_timeout=LIMIT_S)
    except ValueError as error:
        raise NoClusterError(f"{dask}: {error}") from error
    except Exception as error:  # what is not Dask may answer with anything
        text = f"{dask}: no Dask scheduler answers there"
        raise NoClusterError(text) from error
    finally:
        runner.stop()
    if identity.get("type") != "Scheduler":
        raise NoClusterError(f"{dask}: is a {identity.get('type')}, not a scheduler")


async def _identity(address: str) -> dict[str, Any]:
    async with rpc(address, timeout=LIMIT_S) as other:
        identity: dict[str, Any] = await other.identity()
        return identity


@contextmanager
def _silent() -> Iterator[None]:
    """Keep Dask's log and its warnings on versions and on large tasks from the terminal."""
    names = [_LOGGER, *logging.root.manager.loggerDict]
    loggers = [logging.getLogger(n) for n in names if n.partition(".")[0] == _LOGGER]
    before = [(logger, logger.level) for logger in loggers if logger.level]
    for logger, _ in before:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        with catch_warnings():
            filterwarnings("ignore", module=_LOGGER)
            yield
    finally:
        for logger, level in before:
            logger.setLevel(level)
