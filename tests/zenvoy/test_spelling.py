"""Errors of the Python API name its arguments, and not the options of the command line.

What `zenvoy.load` says about a damaged log, that `zenvoy repair --salvage` saves it, stays a
command, because Python has no such function.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import pytest

import zenvoy
from zenvoy.scenarios import ScenarioError
from zenvoy.studies import compare_laws, sweep, tune
from zenvoy.studies.study import StudyError

SCENARIO: Final = "extends: quickstart\nduration_s: 1\nfleet: {size: 3}\nevents: []\n"
SCHEDULE: Final = "control.schedule=[{at_s: 0.5, model: BCM}]"

Study = dict[str, Any]


def swept(**changes: Any) -> Study:
    return {"scenario": "in/s.yaml", "axes": {"channel.loss.p": [0, 0.5]}, "seeds": 1} | changes


def tuned(**changes: Any) -> Study:
    searched = {
        "scenario": "in/s.yaml",
        "parameters": {"channel.loss.p": {"low": 0, "high": 0.5}},
        "minimize": "smallest_gap_m",
        "trials": 1,
    }
    return searched | changes


def compared(*laws: str, **arguments: Any) -> Any:
    return compare_laws("in/s.yaml", laws, **{"out": "new", **arguments})


ELSEWHERE: Final = "its file is not beside the scenario; allow_code=True"
LAW: Final = "../law.py:LAW"

# Each call and a part of its message, which names what the caller wrote.
REFUSED: Final[dict[str, tuple[Callable[[], Any], str]]] = {
    "scenario: value": (lambda: zenvoy.scenario("in/s.yaml", duration_s=-1), "(duration_s=-1)"),
    "scenario: unknown": (lambda: zenvoy.scenario("nope"), "'nope' is neither a file nor"),
    "scenario: key": (lambda: zenvoy.scenario("in/s.yaml", foo=1), "(foo=1)"),
    "scenario: type": (lambda: zenvoy.scenario("in/s.yaml", seed=set()), "seed: a value of type"),
    "scenario: law": (
        lambda: zenvoy.scenario("in/s.yaml", control={"model": LAW}),
        f"{ELSEWHERE} of zenvoy.scenario runs it  (control.model=",
    ),
    "run: seed": (lambda: zenvoy.run("in/s.yaml", seed=-1), "(seed=-1)"),
    "run: engine": (lambda: zenvoy.run("in/s.yaml", engine="a"), "engine: 'a' is"),  # type: ignore[arg-type]  # what a user may write
    "run: shared": (lambda: zenvoy.run("in/s.yaml", vehicles_per_process=0), "per_process: 0: is"),
    "run: folder": (lambda: zenvoy.run("in/s.yaml", out="in"), "out: in: is not empty"),
    "run: law": (lambda: zenvoy.run("in/law.yaml"), f"{ELSEWHERE} of zenvoy.scenario runs it"),
    "load": (lambda: zenvoy.load("in/s.yaml"), "in/s.yaml: "),
    "sweep: out": (lambda: sweep(swept(), out="in"), "out=in: holds no study, but"),
    "sweep: file": (lambda: sweep(swept(), out="in/s.yaml"), "out=in/s.yaml: is a file"),
    "sweep: another": (lambda: sweep(swept(), out="other"), "out=other: holds another study ("),
    "sweep: settings": (lambda: sweep(swept(settings={"foo": 1})), "foo: unknown key;"),
    "sweep: duration": (lambda: sweep(swept(duration_s=-1)), "(study)"),
    "sweep: law": (
        lambda: sweep(swept(settings={"control.model": LAW})),
        f"{ELSEWHERE} runs it  (study)",
    ),
    "sweep: jobs": (
        lambda: sweep(swept(), jobs=2, dask="tcp://127.0.0.1:1"),
        "jobs: with dask, the workers say",
    ),
    "sweep: address": (lambda: sweep(swept(), dask="x://y"), "dask=x://y: "),
    "tune: out": (lambda: tune(tuned(), out="in"), "out=in: holds no study, but"),
    "tune: file": (lambda: tune(tuned(), out="in/s.yaml"), "out=in/s.yaml: is a file"),
    "tune: at work": (lambda: tune(tuned(), out="held"), "out=held: another zenvoy tune is at"),
    "tune: settings": (lambda: tune(tuned(settings={"foo": 1})), "foo: unknown key;"),
    "tune: law": (
        lambda: tune(tuned(settings={"control.model": LAW})),
        f"{ELSEWHERE} runs it  (study)",
    ),
    "compare_laws: none": (compared, "laws: no law is given"),
    "compare_laws: form": (lambda: compared("{a: 1}"), "(laws={a: 1})"),
    "compare_laws: unknown": (lambda: compared("NOPE"), "(laws=NOPE)"),
    "compare_laws: twice": (lambda: compared("FM", "FM"), "laws=FM: is given twice"),
    "compare_laws: law": (lambda: compared(LAW), f"{ELSEWHERE} runs it  (laws={LAW})"),
    "compare_laws: few labels": (lambda: compared("FM", labels=["a", "b"]), "labels: 2 for 1 laws"),
    "compare_laws: label": (lambda: compared("FM", labels=[" "]), "labels=' ': each law needs"),
    "compare_laws: measure": (lambda: compared("FM", measures=["gaps"]), "(measures=gaps)"),
    "compare_laws: measures": (
        lambda: compared("FM", measures=["collisions"] * 2),
        "measures=collisions: is given twice",
    ),
    "compare_laws: varied": (
        lambda: compared("FM", settings=["control.model=BCM"]),
        "allowed: laws  (control.model=BCM)",
    ),
    "compare_laws: setting": (lambda: compared("FM", settings=["foo=1"]), "(foo=1)"),
    "compare_laws: axis": (
        lambda: compared("CACC:{c1: 0.6}", settings=["control.platoon.c1=0.7"]),
        "is an axis of the study too  (settings)",
    ),
    "compare_laws: seeds": (lambda: compared("FM", seeds=10**6), "at most 100,000  (laws)"),
    "compare_laws: no seeds": (lambda: compared("FM", seeds=0), "(seeds)"),
    "compare_laws: duration": (lambda: compared("FM", duration_s=-3), "(duration_s=-3)"),
    "compare_laws: out": (lambda: compared("FM", out="in"), "out=in: holds no study, but"),
    "compare_laws: jobs": (lambda: compared("FM", jobs=1, dask="x://y"), "jobs: with dask,"),
    "compare_laws: address": (lambda: compared("FM", dask="x://y"), "dask=x://y: "),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("in", "held", "other"):
        (tmp_path / name).mkdir()
    (tmp_path / "in" / "s.yaml").write_text(SCENARIO)
    (tmp_path / "in" / "law.yaml").write_text(f"control: {{model: '{LAW}'}}")
    (tmp_path / "law.py").write_text("")
    (tmp_path / "other" / "study.json").write_text("{}")
    return tmp_path


@pytest.mark.parametrize("which", REFUSED)
def test_no_error_names_an_option(here: Path, which: str) -> None:
    call, expected = REFUSED[which]
    lock = os.open(here / "held", os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    try:
        with pytest.raises((zenvoy.ZenvoyError, ScenarioError, StudyError)) as refused:
            call()
    finally:
        os.close(lock)
    text = str(refused.value)
    assert expected in text
    assert "--" not in text


def test_no_note_of_a_comparison_names_an_option(here: Path) -> None:
    lines: list[str] = []
    compared("FM", settings=[SCHEDULE], seeds=1, jobs=1, on_line=lines.append)
    assert lines[0].endswith("only before that (control.schedule=[] removes it)")
    assert "--" not in "".join(lines)
