"""A run has the same bits on other kinds of processor.

Libraries choose their code by the features of the processor. These tests hide some of them: from
OpenBLAS by the name of its kernels, from numpy by a list, and from the C library by a tunable.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from mcap.reader import make_reader

_FEATURES: Final = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
PROCESSORS: Final[dict[str, dict[str, str]]] = {
    "this one": {},
    "one of 2008": {
        "OPENBLAS_CORETYPE": "Nehalem",
        "NPY_DISABLE_CPU_FEATURES": " ".join(_FEATURES),
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-AVX,-FMA,-FMA4",
    },
    "one of 2013": {"OPENBLAS_CORETYPE": "Haswell"},
}

BURSTS = "channel.loss.gilbert_elliott={p: 0.05, r: 0.3}"
SETTINGS: Final = {
    "PBCM, by radar": ["seed=2"],
    "PBCM, normal errors and losses": ["sensors.distribution=gaussian", BURSTS],
    "MBCM, by position": ["control.schedule.0.model=MBCM", "control.neighbour_state=position"],
    "PBCM, received power": ["channel.loss.path_loss={fading_m: 1.5}"],
    "IDM": ["control.schedule.0.model=IDM"],
    "dCACC": ["control.schedule.0.model=dCACC", "channel.loss.p=0.9"],
    "CACC": ["control.schedule.0.model=CACC", "sensors.position_std_m=1.5"],
}


def fingerprint(folder: Path, processor: dict[str, str], settings: list[str]) -> str:
    """Return the fingerprint of 15 s of case 15, which switches at 1 s and brakes at 3 s."""
    command = [sys.executable, "-m", "zenvoy.cli", "run", "paper/case-15"]
    command += ["--bus", "in-process", "--out", str(folder), "--duration-s", "15"]
    for setting in ("control.schedule.0.at_s=1", "events.0.at_s=3", *settings):
        command += ["--set", setting]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **processor})
    with (folder / "run.mcap").open("rb") as stream:
        for record in make_reader(stream).iter_metadata():
            if record.name == "zenvoy.result":
                return record.metadata["fingerprint"]
    raise AssertionError("no fingerprint")


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_a_run_is_the_same_on_other_processors(tmp_path: Path, settings: list[str]) -> None:
    found = {
        name: fingerprint(tmp_path / name, processor, settings)
        for name, processor in PROCESSORS.items()
    }
    assert found == dict.fromkeys(PROCESSORS, found["this one"])
