"""In whole fleets without noise, each model commands what follows from the truth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import EVENTS, FRAMES, Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import Scenario

Table = dict[str, NDArray[Any]]

K_D, K_V, K_C, V_DES = 0.1, 0.5, 0.05, 30.0
RING_M = 12 * 37.5
BRAKE = [{"type": "brake", "vehicle": 5, "at_s": 0.5, "duration_s": 1.0, "deceleration_mps2": 2.0}]


def simulate(**sections: Any) -> dict[str, Any]:
    """Run in process, and return tables by topic, stacked over time (frames, events: lists)."""
    base: dict[str, Any] = {
        "duration_s": 6.0,
        "fleet": {"size": 12},
        "sensors": {"error": 0.0},
        "events": BRAKE,
    }
    scenario = Scenario.model_validate(base | sections)
    rows: dict[str, list[Table]] = {}
    codecs: dict[str, PackedCodec] = {}
    events: list[pb.Event] = []

    def log(topic: Topic[Any], _time_ns: int, payload: bytes) -> None:
        if topic is EVENTS:
            events.append(EVENTS.decode(payload))
            return
        codec = codecs.setdefault(topic.name, PackedCodec(topic.message.DESCRIPTOR))
        rows.setdefault(topic.name, []).append(codec.decode(payload))

    InProcessBus(agents_of(scenario), log).run()
    frames = rows.pop(FRAMES.name)
    tables = {
        name: {column: np.stack([row[column] for row in of_topic]) for column in of_topic[0]}
        for name, of_topic in rows.items()
    }
    return {**tables, "frames": frames, "events": events}


def shifted(column: NDArray[Any], by: int) -> NDArray[Any]:
    """Return the column of the vehicle `by` places ahead (negative: behind), on the ring."""
    return np.asarray(np.roll(column, by, axis=1))


def position_ahead(position: NDArray[Any], by: int) -> NDArray[Any]:
    """Return the position of the vehicle `by` places ahead, unwrapped across the seam."""
    n = position.shape[1]
    lap = (np.arange(n)[None, :] < by).astype(float) - (np.arange(n)[None, :] >= n + by)
    return np.asarray(shifted(position, by) + RING_M * lap)


def pulls(truth: Table, j: int) -> NDArray[Any]:
    """Return k_d (p_{i-j} - 2 p_i + p_{i+j}) + k_v (the same in v) of all vehicles at t_k."""
    p, v = truth["position"][:-1], truth["speed"][:-1]
    stretch = position_ahead(p, j) - 2 * p + position_ahead(p, -j)
    return np.asarray(K_D * stretch + K_V * (shifted(v, j) - 2 * v + shifted(v, -j)))


@pytest.mark.parametrize("state", ["radar", "position"])
@pytest.mark.parametrize(
    ("model", "multi_node", "weights"),
    [
        ("BCM", {}, (1.0,)),
        ("MBCM", {}, (1 / 14, 4 / 14, 9 / 14)),
        ("MBCM", {"neighbours": 2, "weights": "uniform"}, (0.5, 0.5)),
        ("MBCM", {"neighbours": 4, "weights": [0.4, 0.3, 0.2, 0.1]}, (0.4, 0.3, 0.2, 0.1)),
    ],
)
def test_bilateral_commands_follow_from_the_truth(
    model: str, multi_node: Any, weights: tuple[float, ...], state: str
) -> None:
    control = {"model": model, "multi_node": multi_node, "neighbour_state": state}
    tables = simulate(control=control)
    truth, speed = tables["truth"], tables["truth"]["speed"][:-1]
    expected = sum(c * pulls(truth, j) for j, c in enumerate(weights, 1)) + K_C * (V_DES - speed)
    if state == "position":
        # A vehicle decides 11 ms after t_k, when its own position is 11 ms newer than the others'.
        # So it seems to be v · 11 ms nearer to the vehicle ahead, and farther from the one behind.
        expected -= 2 * K_D * speed * 0.011 * sum(weights)
    expected = np.clip(expected, -3.0, 3.0)
    np.testing.assert_allclose(tables["fleet command"]["acceleration"], expected, atol=1e-9)
    assert np.abs(expected).max() > 0.5
    m = len(weights) if model == "MBCM" else 0
    assert np.unique(tables["estimate"]["neighbours"]).tolist() == ([m] if m else [])


def test_a_chain_ends_at_the_range() -> None:
    """5G mmWave reaches 50 m: at spacings of 37.5 m, only the next vehicle."""
    control = {"model": "MBCM"}
    near = simulate(control=control, channel={"technology": "5g-mmwave"})
    bcm = simulate(control={"model": "BCM"}, channel={"technology": "5g-mmwave"})
    assert np.all(near["estimate"]["neighbours"] == 1)
    assert np.array_equal(
        near["fleet command"]["acceleration"], bcm["fleet command"]["acceleration"]
    )


def test_the_shorter_side_limits_a_chain() -> None:
    """Vehicle 6 sends nothing, so vehicles that need its data use fewer neighbours."""
    fleet = {"size": 12, "groups": [{"name": "mute", "vehicles": 6, "beacons": False}]}
    tables = simulate(fleet=fleet, control={"model": "MBCM"})
    # Vehicle i + j reports the j-th gap behind, and vehicle i - j + 1 the j-th gap ahead. The own
    # radar reads the first.
    expected = [3, 3, 2, 1, 0, 3, 1, 2, 3, 3, 3, 3]
    assert np.all(tables["estimate"]["neighbours"] == expected)
    modes = tables["estimate"]["mode"][-1].tolist()
    assert modes == [pb.MODE_MBCM] * 4 + [pb.MODE_FALLBACK_FM] + [pb.MODE_MBCM] * 7
    assert all(6 not in frames["source"] for frames in tables["frames"])
    assert all(6 in frames["destination"] for frames in tables["frames"])
    falls = [event for event in tables["events"] if event.kind == pb.EVENT_FALLBACK]
    assert [(event.vehicle, event.cycle) for event in falls] == [(5, 0)]


@pytest.mark.parametrize("state", ["radar", "position"])
def test_laws_respect_the_ends_of_the_open_road(state: str) -> None:
    control = {"model": "MBCM", "neighbour_state": state}
    tables = simulate(road={"type": "open"}, control=control)
    assert np.all(tables["estimate"]["neighbours"] == [0, 1, 2, *[3] * 6, 2, 1, 0])
    truth, a = tables["truth"], tables["fleet command"]["acceleration"]
    p, v = truth["position"][:-1], truth["speed"][:-1]
    here = p + (0.011 * v if state == "position" else 0.0)  # where a vehicle is when it decides
    last = K_D * (p[:, -2] - here[:, -1] - 37.5) + K_V * (v[:, -2] - v[:, -1])
    np.testing.assert_allclose(a[:, -1], last + K_C * (V_DES - v[:, -1]), atol=1e-9)
    second = K_D * (p[:, 0] - 2 * here[:, 1] + p[:, 2]) + K_V * (v[:, 0] - 2 * v[:, 1] + v[:, 2])
    expected = np.clip(second + K_C * (V_DES - v[:, 1]), -3.0, 3.0)
    np.testing.assert_allclose(a[:, 1], expected, atol=1e-9)
    assert np.all(a[:, 0] == 0.0)


@pytest.mark.parametrize("size", [None, 4])
def test_platoons_follow_predecessor_and_leader(size: int | None) -> None:
    control = {"model": "CACC", "platoon": {"size": size}, "system_delay_ms": 189}
    tables = simulate(control=control)
    truth, a = tables["truth"], tables["fleet command"]["acceleration"]
    p, v = truth["position"][:-1], truth["speed"][:-1]
    leaders = np.arange(12) // (size or 12) * (size or 12)
    ahead, gap = shifted(v, 1), position_ahead(p, 1) - p
    # The acceleration from t_k that vehicles report: the command that took effect last, decided in
    # cycle k - 2 for t_k. Vehicle 5 contradicts that while it brakes.
    reported = np.vstack([np.zeros((2, 12)), a[:-2]])
    read = truth["acceleration"][:-1]
    meant = np.vstack([np.zeros((3, 12)), a[:-3]])[: len(read)]
    reported = np.where(np.abs(read - meant) > 0.1, read, reported)
    follow = K_D * (gap - 37.5) + K_V * (ahead - v) + K_C * (V_DES - v)
    cooperate = 0.5 * shifted(reported, 1) + 0.5 * reported[:, leaders] + 0.3 * (ahead - v)
    cooperate += 0.1 * (v[:, leaders] - v) + 0.04 * (gap - 37.5)
    expected = np.where(leaders == np.arange(12), follow, cooperate)
    np.testing.assert_allclose(a, np.clip(expected, -3.0, 3.0), atol=1e-9)
    modes = np.where(leaders == np.arange(12), pb.MODE_FM, pb.MODE_CACC)
    assert np.all(tables["estimate"]["mode"] == modes)
    assert np.abs(a[:, ::5]).max() > 0.01


def test_vehicles_fall_back_if_their_leader_is_out_of_range() -> None:
    control = {"model": "CACC", "platoon": {"size": 4}}
    tables = simulate(control=control, channel={"technology": "5g-mmwave"})
    two = [pb.MODE_FM, pb.MODE_CACC, pb.MODE_FALLBACK_FM, pb.MODE_FALLBACK_FM]
    assert np.all(tables["estimate"]["mode"] == two * 3)


@pytest.mark.parametrize("model", ["BCM", "MBCM"])
def test_old_positions_slow_the_flow(model: str) -> None:
    """v = k_c v_des / (k_c + 2 k_d τ), with τ = 0.1 s if only the last cycle's are known."""
    control = {
        "model": model,
        "neighbour_state": "position",
        "v2v_wait_ms": 0,
        "system_delay_ms": 100,
    }
    tables = simulate(control=control, duration_s=120.0, events=[], fleet={"size": 8})
    v = K_C * V_DES / (K_C + 2 * K_D * 0.1)
    np.testing.assert_allclose(tables["truth"]["speed"][-1], v, rtol=1e-3)


def test_prediction_makes_up_for_old_positions() -> None:
    control = {"model": "PBCM", "neighbour_state": "position", "v2v_wait_ms": 0}
    tables = simulate(control=control, duration_s=60.0, events=[], fleet={"size": 8})
    np.testing.assert_allclose(tables["truth"]["speed"][-1], V_DES, rtol=1e-3)


def test_pbcm_is_the_same_with_positions_and_with_radar() -> None:
    """Without noise both readings are the truth at the same times."""
    by = {}
    for state in ("radar", "position"):
        control = {"model": "PBCM", "neighbour_state": state}
        by[state] = simulate(control=control)["truth"]["speed"]
    np.testing.assert_allclose(by["position"], by["radar"], atol=1e-6)
    assert np.ptp(by["radar"]) > 1.0


def test_every_vehicle_follows_the_model_of_its_group_and_schedule() -> None:
    fleet = {
        "size": 12,
        "groups": [
            {"name": "humans", "share": 0.5, "model": "FM", "beacons": False},
            {"name": "eager", "vehicles": "not humans", "gains": {"k_d": 0.3}},
        ],
    }
    schedule = [
        {"at_s": 1, "model": "BCM"},
        {"at_s": 2, "model": "MBCM", "vehicles": "eager"},
        {"at_s": 2, "model": "CACC", "vehicles": "1-2"},
    ]
    control = {"model": "PBCM", "schedule": schedule}
    tables = simulate(fleet=fleet, control=control, duration_s=3.0)
    speakers = {source for frames in tables["frames"] for source in frames["source"].tolist()}
    assert len(speakers) == 6
    modes = tables["estimate"]["mode"]
    mute = [v - 1 for v in range(1, 13) if v not in speakers]
    assert np.all(modes[:20, mute] == pb.MODE_FM)
    others = {9: {pb.MODE_PBCM}, 19: {pb.MODE_BCM}, 29: {pb.MODE_MBCM, pb.MODE_CACC}}
    for cycle, allowed in others.items():
        found = {int(modes[cycle, v - 1]) for v in speakers}
        assert found <= allowed | {pb.MODE_FALLBACK_FM, pb.MODE_FM}, cycle
        assert found & allowed, cycle
    switches = [e.text for e in tables["events"] if e.kind == pb.EVENT_MODEL]
    assert switches == ["BCM", "MBCM: eager", "CACC: 1-2"]
