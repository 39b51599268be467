"""Each of the built-in scenarios runs, is described, and is in the package."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from ruamel.yaml import YAML

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import EVENTS, FRAMES, TRUTH, Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import (
    Loaded,
    Scenario,
    builtin,
    effective_yaml,
    load,
    technologies,
)

ROOT: Final = Path(__file__).parents[2]
NAMES: Final = [name for name, _ in builtin()]
S_NS: Final = 1_000_000_000


def run(scenario: Scenario) -> dict[Topic[Any], list[bytes]]:
    """Return the messages that the log of a run would have, by topic."""
    log: dict[Topic[Any], list[bytes]] = {}

    def keep(topic: Topic[Any], _time_ns: int, data: bytes) -> None:
        log.setdefault(topic, []).append(data)

    InProcessBus(agents_of(scenario), keep).run()
    return log


def shortened(name: str) -> Loaded:
    """Load a scenario with few vehicles and three seconds, and move its events into them."""
    whole = load(name).scenario
    settings = ["duration_s=3", f"fleet.size={min(7, whole.fleet.size)}"]  # MBCM needs 7
    for i, group in enumerate(whole.fleet.groups):
        settings += [f"fleet.groups.{i}.vehicles=1-4"] if group.vehicles else []
    settings += [f"events.{i}.at_s=1" for i, _ in enumerate(whole.events)]
    settings += [f"faults.{i}.at_s=1" for i, _ in enumerate(whole.faults)]
    settings += [f"control.schedule.{i}.at_s={i + 1}" for i, _ in enumerate(whole.control.schedule)]
    return load(name, settings)


@pytest.mark.parametrize("name", NAMES)
def test_each_scenario_runs_to_the_end(name: str) -> None:
    scenario = shortened(name).scenario
    log = run(scenario)
    truth = [pb.FleetTruth.FromString(data) for data in log[TRUTH]]
    assert [row.time_ns for row in truth[:: scenario.cycles]] == [0, 3 * S_NS]
    assert all(np.isfinite(row.position).all() for row in truth)
    events = [pb.Event.FromString(data) for data in log[EVENTS]] if EVENTS in log else []
    kinds = {event.kind for event in events}
    assert not kinds & {pb.EVENT_COLLISION, pb.EVENT_STOPPED}
    assert (pb.EVENT_BRAKE in kinds) == bool(scenario.brakes)
    assert (pb.EVENT_FAULT in kinds) == bool(scenario.faults)
    returns = any(brake.return_s is not None for brake in scenario.brakes)  # it counts as a trace
    assert (pb.EVENT_TRACE in kinds) == (bool(scenario.profiles) or returns)
    schedule = scenario.control.schedule
    assert (pb.EVENT_MODEL in kinds) == any(switch.model for switch in schedule)
    assert (pb.EVENT_TARGET in kinds) == any(switch.targets for switch in schedule)


@pytest.mark.parametrize("name", NAMES)
def test_frames_are_in_time_unless_they_are_lost(name: str) -> None:
    """The wait of each scenario fits its technology."""
    scenario = shortened(name).scenario
    log = run(scenario)
    codec = PackedCodec(pb.Frames.DESCRIPTOR)
    outcomes = np.concatenate([codec.decode(data)["outcome"] for data in log[FRAMES]])
    allowed = {pb.OUTCOME_DELIVERED, pb.OUTCOME_OUT_OF_RANGE, pb.OUTCOME_LOST}
    if any(fault.type == "transmitter-babbling" for fault in scenario.faults):
        allowed |= {pb.OUTCOME_COLLIDED, pb.OUTCOME_LATE}
    assert set(outcomes.tolist()) <= allowed
    loss = load(name).scenario.channel.loss
    lost = float(np.mean(outcomes == pb.OUTCOME_LOST))
    bursts = loss.gilbert_elliott
    # 30 cycles of 7 vehicles or so: 1260 frames, so ±0.1 is six standard deviations. In bursts of
    # 10 frames, about 14 neighbouring frames count as one.
    share, margin = (bursts.p / (bursts.p + bursts.r), 0.3) if bursts.p else (loss.p, 0.1)
    assert lost == pytest.approx(share, abs=margin if share else 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_each_scenario_is_written_and_read_back(name: str, tmp_path: Path) -> None:
    scenario = load(name).scenario
    path = tmp_path / "s.yaml"
    path.write_text(effective_yaml(scenario))
    assert load(path).scenario == scenario


def test_each_scenario_has_its_own_description() -> None:
    lines = [description for _, description in builtin()]
    assert len(set(lines)) == len(lines)
    assert all(0 < len(line) <= 100 and line.isprintable() for line in lines)


def _leaves(values: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    if not isinstance(values, dict):
        yield path, values
        return
    for key, value in values.items():
        yield from _leaves(value, (*path, key))


EXTENSIONS: Final = [name for name in NAMES if re.search("^extends:", load(name).text, re.M)]


@pytest.mark.parametrize("name", EXTENSIONS)
def test_an_extension_has_only_what_differs(name: str) -> None:
    written = YAML(typ="safe", pure=True).load(load(name).text)
    base = dict(_leaves(load(written.pop("extends")).scenario.model_dump(mode="json")))
    assert [path for path, value in _leaves(written) if base.get(path) == value] == []


def test_the_package_includes_every_file_of_the_library() -> None:
    """The test applies package-data as setuptools does."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())
    patterns = data["tool"]["setuptools"]["package-data"]["*"]
    folder = ROOT / "scenarios"
    taken = {path for pattern in patterns for path in folder.glob(pattern)}
    assert [p for p in folder.rglob("*") if p.suffix in {".yaml", ".csv"} and p not in taken] == []
    names = {p.relative_to(folder).with_suffix("").as_posix() for p in folder.rglob("*.yaml")}
    assert names == {*NAMES, *(f"radios/{name}" for name in technologies())}
    assert all(files("zenvoy.scenarios").joinpath(f"{name}.yaml").is_file() for name in NAMES)
