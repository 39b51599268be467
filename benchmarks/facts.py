"""The machine and the versions on which a benchmark was measured."""

import datetime
import os
import platform
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path


def facts(packages: Iterable[str]) -> list[str]:
    """Return the facts as lines of Markdown; call this before the runs, which raise the load."""
    cpuinfo = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    models = [line.partition(":")[2].strip() for line in cpuinfo if line.startswith("model name")]
    values = {
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "cores": str(len(os.sched_getaffinity(0))),
        "CPU": models[0] if models else platform.machine(),
        "load before": f"{os.getloadavg()[0]:.1f}",
        "Python": platform.python_version(),
        **{package: version(package) for package in packages},
    }
    return [f"- {fact}: {value}" for fact, value in values.items()]
