"""`zenvoy channel` draws the frames that a run of the scenario would have."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.rehearsal import rehearse
from zenvoy.scenarios import load

SCENARIO = """
duration_s: 8
fleet:
  size: 6
  groups: [{name: mute, vehicles: 4, beacons: false}]
channel:
  technology: lte-a-pro
  duplicate: 0.1
  loss: {p: 0.1, corrupt: 0.05, gilbert_elliott: {p: 0.1, r: 0.3}}
  rules: [{from_s: 2, until_s: 4, source: 2, latency: {distribution: fixed, mean_ms: 150}}]
  outages: [{from_s: 5, until_s: 6, destination: 1}]
"""
NAMES = ("source", "destination", "sequence", "sent_ns", "arrived_ns", "outcome")


def test_frames_equal_those_of_a_run(tmp_path: Path) -> None:
    """Nothing in this channel depends on the positions of the vehicles."""
    logged = load_log(write_log(tmp_path / "run.mcap", SCENARIO)).frames
    tables = list(rehearse(load(tmp_path / "run.yaml").scenario))
    for name in NAMES:
        drawn: NDArray[Any] = np.concatenate([table[name] for table in tables])
        np.testing.assert_array_equal(drawn, logged[name])
    lost = {pb.OUTCOME_LOST, pb.OUTCOME_CORRUPTED, pb.OUTCOME_DUPLICATE}
    kinds = {pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE, *lost}
    assert set(np.unique(logged["outcome"]).tolist()) == kinds
    assert not (logged["source"] == 4).any()


def test_the_command_writes_tables_pictures_and_a_page(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO)
    outcome = zenvoy(tmp_path, "channel", "s.yaml", "--duration-s", "4", "--out", "out")
    assert outcome.code == 0, outcome.err
    assert "6 vehicles on a ring of 225 m" in outcome.out
    left = {path.name for path in (tmp_path / "out").iterdir()}
    pictures = ("v2v-latency", "v2v-delivery", "v2v-bursts", "v2v-age", "v2v-age-map")
    assert left >= {f"{name}.{kind}" for name in pictures for kind in ("png", "svg")}
    assert {"channel.html", "v2v-delivery.csv", "v2v-distance.csv"} <= left
    with (tmp_path / "out" / "v2v-delivery.csv").open(newline="") as file:
        header, row = list(csv.reader(file))
    counts = dict(zip(header, row, strict=True))
    assert int(counts["sent"]) == 5 * 5 * 40  # from five that send beacons, to five others each
    assert int(counts["damaged"]) > 0
    assert int(counts["second copies"]) > 0


def test_the_command_refuses_what_run_refuses(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "channel", "quickstart", "--set", "channel.loss.p=2")
    assert outcome.code == 2
    assert "channel.loss.p: 2 is not in [0, 1]" in outcome.err
    assert not (tmp_path / "runs").exists()
