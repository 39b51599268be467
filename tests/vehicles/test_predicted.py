"""Predictions of a vehicle for the time of effect agree with closed forms."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cab import AHEAD, BEHIND, STILL, T_NS, T_S, Cab, beacon, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Gains


@dataclass(frozen=True)
class Course:
    """A vehicle under constant acceleration, from t = 0."""

    p: float
    v: float
    a: float

    def position(self, t: float) -> float:
        return self.p + self.v * t + 0.5 * self.a * t * t

    def speed(self, t: float) -> float:
        return self.v + self.a * t


def gap(rear: Course, front: Course, t: float) -> float:
    return front.position(t) - rear.position(t)


def closing(rear: Course, front: Course, t: float) -> float:
    return front.speed(t) - rear.speed(t)


accelerations = st.floats(-2.5, 2.5)


@settings(deadline=None, max_examples=60)
@given(
    own_a=st.just(0.0) | st.floats(0.2, 2.5) | st.floats(-2.5, -0.2),
    ahead_a=accelerations,
    behind_a=accelerations,
    gaps=st.tuples(st.floats(20.0, 60.0), st.floats(20.0, 60.0)),
    speeds=st.tuples(st.floats(20.0, 35.0), st.floats(20.0, 35.0), st.floats(20.0, 35.0)),
    delay_ms=st.integers(0, 350),
    wait_ms=st.sampled_from([0, 11, 50]),
    late=st.tuples(st.integers(0, 4), st.integers(0, 4)),
)
def test_constant_accelerations_are_predicted_exactly(
    own_a: float,
    ahead_a: float,
    behind_a: float,
    gaps: tuple[float, float],
    speeds: tuple[float, float, float],
    delay_ms: int,
    wait_ms: int,
    late: tuple[int, int],
) -> None:
    """Without noise, predictions for the time of effect equal the closed form.

    The ego vehicle commands nothing, so its motion contradicts its commands, and it expects that
    motion to go on. Each neighbour's frames are `late` by that many cycles.
    """
    own = Course(0.0, speeds[0], own_a)
    front = Course(gaps[0], speeds[1], ahead_a)
    rear = Course(-gaps[1], speeds[2], behind_a)
    cab = Cab(scenario(gains=STILL, wait_ms=wait_ms, delay_ms=delay_ms))
    for k in range(20):
        t = k * T_S
        cab.sense(
            gap=gap(own, front, t),
            relative_speed=closing(own, front, t),
            speed=own.speed(t),
            acceleration=own_a,
        )
        heard: list[pb.Beacon] = []
        if k >= late[0]:
            heard.append(beacon(AHEAD, k - late[0], acceleration=ahead_a))
        if k >= late[1]:
            then = (k - late[1]) * T_S
            heard.append(
                beacon(
                    BEHIND,
                    k - late[1],
                    gap=gap(rear, own, then),
                    relative_speed=closing(rear, own, then),
                    speed=rear.speed(then),
                    acceleration=behind_a,
                )
            )
        command = cab.receive(heard)
        effect = command.effective_ns * 1e-9
        assert effect == pytest.approx(t + (wait_ms + delay_ms) * 1e-3, abs=1e-12)
        assert command.predicted_speed == pytest.approx(own.speed(effect), abs=1e-9)
        if late[0] == 0:
            ahead = command.ahead
            assert ahead.gap == pytest.approx(gap(own, front, t), abs=1e-9)
            assert ahead.speed == pytest.approx(closing(own, front, t), abs=1e-9)
            assert ahead.predicted_gap == pytest.approx(gap(own, front, effect), abs=1e-9)
            assert ahead.predicted_speed == pytest.approx(closing(own, front, effect), abs=1e-9)
        if k >= late[1]:
            behind = command.behind
            assert behind.measured_ns == (k - late[1]) * T_NS
            assert behind.predicted_gap == pytest.approx(gap(rear, own, effect), abs=1e-9)
            assert behind.predicted_speed == pytest.approx(closing(rear, own, effect), abs=1e-9)


def test_predictions_include_pending_commands() -> None:
    """The own commands take effect as commanded, 300 ms after the start of the cycle."""
    cab = Cab(scenario(delay_ms=289, wait_ms=11, gains=Gains(k_d=0.02, k_v=0.1, k_c=0.05)))
    steps: list[tuple[float, float]] = []  # (from, a) of the ego; the neighbours keep 30 m/s

    def ego(t: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration by exact integration of the commands."""
        p, v, now, a = 0.0, 25.0, 0.0, 0.0
        for start, value in steps:
            if start >= t:
                break
            p += v * (start - now) + 0.5 * a * (start - now) ** 2
            v, now, a = v + a * (start - now), start, value
        return p + v * (t - now) + 0.5 * a * (t - now) ** 2, v + a * (t - now), a

    for k in range(25):
        t = k * T_S
        p, v, _ = ego(t)
        before = ego(max(0.0, t - T_S))[1]
        cab.sense(
            gap=60.0 + 30.0 * t - p,
            relative_speed=30.0 - v,
            speed=v,
            acceleration=(v - before) / T_S,
        )
        rear = beacon(
            BEHIND, k, gap=p - (30.0 * t - 40.0), relative_speed=v - 30.0, acceleration=0.0
        )
        command = cab.receive([beacon(AHEAD, k), rear])
        effect = t + 0.3
        p, v, _ = ego(effect)
        assert command.predicted_speed == pytest.approx(v, abs=1e-9)
        assert command.ahead.predicted_gap == pytest.approx(60.0 + 30.0 * effect - p, abs=1e-9)
        assert command.behind.predicted_speed == pytest.approx(v - 30.0, abs=1e-9)
        predicted = (
            0.02 * (command.ahead.predicted_gap - command.behind.predicted_gap)
            + 0.1 * (command.ahead.predicted_speed - command.behind.predicted_speed)
            + 0.05 * (30.0 - command.predicted_speed)
        )
        assert command.mode == pb.MODE_PBCM
        assert command.acceleration == pytest.approx(predicted, abs=1e-12)
        steps.append((effect, command.acceleration))
    assert max(abs(a) for _, a in steps) > 0.3


def test_no_predicted_speed_is_negative() -> None:
    cab = Cab(scenario(gains=STILL, delay_ms=500))
    cab.sense(speed=0.5, acceleration=-3.0)
    assert cab.receive().predicted_speed == 0.0


def test_an_old_plan_of_the_vehicle_ahead_is_forgotten() -> None:
    cab = Cab(scenario(gains=STILL, age_limit_ms=300))
    predictions = []
    for k in range(8):
        cab.sense()
        command = cab.receive([beacon(AHEAD, k, acceleration=2.0)] if k == 0 else [])
        ahead = command.ahead
        predictions.append(ahead.predicted_speed - ahead.speed)
    assert predictions == pytest.approx([0.2] * 4 + [0.0] * 4, abs=1e-9)
