"""Two vehicles share the estimate of their link: what each of them knows, and when."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cab import T_NS, T_S, Cab
from tests.cab import scenario as scenario_of
from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario, Sensors
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.odometer import Odometer, coasted, moved, offset_of, state_of
from zenvoy.vehicles.received import ReceivedBeacon
from zenvoy.vehicles.shared_links import SharedLinks
from zenvoy.vehicles.unheard import UNHEARD_STD, unheard_gains

EFFECT_NS: Final = 100_000_000
NOISY: Final = 0.1


def scenario(error: float = 0.0) -> Scenario:
    return scenario_of(model="SPBCM").model_copy(update={"sensors": Sensors(error=error)})


class Driver:
    """A vehicle that accelerates as it is told, and shares its links."""

    def __init__(self, position: float, speed: float, error: float = 0.0) -> None:
        self.motion = Motion(10 * T_NS)
        self.links = SharedLinks(scenario(error), self.motion)
        self.position, self.speed, self.a = position, speed, 0.0

    def sense(self, cycle: int, radar: Relative | None, a: float) -> ReceivedBeacon:
        """Begin a cycle, in which the acceleration is `a`; return the beacon."""
        now_ns = cycle * T_NS
        self.motion.learn(now_ns - T_NS, now_ns, self.a, [now_ns], [a])
        report = self.links.sense(now_ns, radar, self.speed)
        before, self.a = self.a, a
        return ReceivedBeacon(
            1, now_ns, self.position, self.speed, before, radar, (now_ns,), (a,), None, report
        )

    def move(self, a: float) -> None:
        self.position += self.speed * T_S + 0.5 * a * T_S**2
        self.speed += a * T_S


class Pair:
    """A vehicle and the one behind it. Each hears the other in the cycles that it is told."""

    def __init__(self, error: float = 0.0) -> None:
        self.front, self.rear = Driver(40.0, 30.0, error), Driver(0.0, 30.0, error)
        self.cycle = -1

    @property
    def truth(self) -> Relative:
        front, rear = self.front, self.rear
        return Relative(front.position - rear.position, front.speed - rear.speed)

    def step(
        self,
        accelerations: tuple[float, float],
        hears: tuple[bool, bool] = (True, True),
        *,
        noise: tuple[float, float] = (0.0, 0.0),
    ) -> tuple[Relative | None, Relative | None]:
        """Run a cycle; return the state at its effect, as the front and as the rear know it."""
        front, rear = self.front, self.rear
        if self.cycle >= 0:
            front.move(front.a)
            rear.move(rear.a)
        self.cycle += 1
        radar = Relative(self.truth.p + noise[0], self.truth.v + noise[1])
        of_front = front.sense(self.cycle, None, accelerations[0])
        of_rear = rear.sense(self.cycle, radar, accelerations[1])
        if hears[0]:
            front.links.hear_behind(of_rear)
        if hears[1]:
            rear.links.hear_ahead(of_front)
        until_ns = self.cycle * T_NS + EFFECT_NS
        return front.links.predict(until_ns)[1], rear.links.predict(until_ns)[0]

    def at_effect(self) -> Relative:
        """Return the true state when the command of this cycle takes effect."""
        p, v, a = *self.truth, self.front.a - self.rear.a
        return Relative(p + v * T_S + 0.5 * a * T_S**2, v + a * T_S)


ACCELERATION = st.floats(-3.0, 3.0)
CYCLES = st.lists(
    st.tuples(st.tuples(ACCELERATION, ACCELERATION), st.tuples(st.booleans(), st.booleans())),
    min_size=1,
    max_size=40,
)


@settings(deadline=None, max_examples=100)
@given(CYCLES)
def test_after_any_burst_both_know_the_link_at_once(
    cycles: list[tuple[tuple[float, float], tuple[bool, bool]]],
) -> None:
    """Sensors make no error here; the vehicles do what they like while nobody hears them."""
    pair = Pair()
    pair.step((0.0, 0.0))
    for accelerations, hears in cycles:
        pair.step(accelerations, hears)
    for known in pair.step((1.0, -1.0)):
        assert known == pytest.approx(pair.at_effect(), abs=1e-6)


NOISE = st.tuples(st.floats(-4.0, 4.0), st.floats(-3.0, 3.0))


@settings(deadline=None, max_examples=100)
@given(st.lists(st.tuples(ACCELERATION, ACCELERATION, NOISE), min_size=1, max_size=40))
def test_both_act_on_the_same_estimate(
    cycles: list[tuple[float, float, tuple[float, float]]],
) -> None:
    pair = Pair(NOISY)
    for front_a, rear_a, noise in cycles:
        front, rear = pair.step((front_a, rear_a), noise=noise)
        assert front == pytest.approx(rear, abs=1e-9)


def test_the_error_of_the_estimate_is_that_of_a_kalman_filter_without_inputs() -> None:
    """Whatever the vehicles do, the readings minus the odometers measure a constant."""
    rng = np.random.default_rng(1)
    restless, calm = Pair(NOISY), Pair(NOISY)
    for cycle in range(50):
        noise = (rng.normal(0.0, 2.0), rng.normal(0.0, 1.7))
        a = 3.0 if cycle % 8 < 4 else -3.0
        restless.step((a, -a), noise=noise)
        calm.step((0.0, 0.0), noise=noise)
        assert errors(restless) == pytest.approx(errors(calm), abs=1e-9)


def errors(pair: Pair) -> tuple[float, float]:
    estimate = pair.rear.links.ahead.estimate
    assert estimate is not None
    return estimate.p - pair.truth.p, estimate.v - pair.truth.v


def test_a_radar_follows_a_vehicle_that_brakes_unheard() -> None:
    pair = Pair()
    for _ in range(5):
        pair.step((0.0, 0.0))
    for _ in range(20):
        _, known = pair.step((-3.0, 0.0), (True, False))
    assert known == pytest.approx(pair.at_effect(), abs=0.5)
    assert pair.truth.v < -3.0


def test_the_front_supposes_that_an_unheard_vehicle_behind_keeps_its_speed() -> None:
    pair = Pair()
    for _ in range(5):
        pair.step((0.0, -1.0))
    start = pair.at_effect()
    for _ in range(30):
        known, _ = pair.step((0.5, -3.0), (False, True))
    t = 30 * T_S  # its plan ends where it was last heard
    assert known == pytest.approx((start.p + start.v * t + 0.25 * t * t, start.v + 0.5 * t))
    assert pair.front.links.behind_age_s == pytest.approx(3.0)


def test_an_odometer_that_begins_anew_is_not_mixed_up_with_the_old_one() -> None:
    pair = Pair()
    for _ in range(5):
        pair.step((2.0, -1.0))
    again = Driver(pair.front.position, pair.front.speed)
    again.a, pair.front = pair.front.a, again
    known, _ = pair.step((0.0, 0.0), (True, False))
    assert known is None  # the offset refers to an odometer that is gone
    pair.step((0.0, 0.0))
    for known in pair.step((0.0, 0.0)):
        assert known == pytest.approx(pair.at_effect(), abs=1e-6)


def test_a_vehicle_that_reports_nothing_is_followed_by_radar() -> None:
    pair = Pair()
    for _ in range(80):
        pair.step((0.0, 0.0), (False, False))
    silent = replace_report(pair)
    pair.rear.links.hear_ahead(silent)
    pair.front.links.hear_behind(silent)
    front, rear = pair.step((0.0, 0.0), (False, False))
    assert front is None
    assert rear == pytest.approx(pair.at_effect(), abs=1e-3)


def replace_report(pair: Pair) -> ReceivedBeacon:
    """Return a beacon of the newest cycle of a vehicle that does not share its links."""
    return ReceivedBeacon(1, pair.cycle * T_NS, 0.0, 30.0, 0.0, None, (), (), None)


@pytest.mark.parametrize("model", ["PBCM", "SPBCM"])
def test_only_a_fleet_that_shares_links_reports_them(model: str) -> None:
    sent = Cab(scenario_of(model=model)).sense()
    assert [sent.HasField(name) for name in ("odometer", "offset")] == [model == "SPBCM"] * 2


def test_the_gain_of_an_unheard_vehicle_is_that_of_the_textbook() -> None:
    variances = (4.6875, 3.0)
    F = np.array([[1.0, T_S], [0.0, 1.0]])
    B = np.array([[T_S**2 / 2], [T_S]])
    Q, R, P = UNHEARD_STD**2 * B @ B.T, np.diag(variances), np.zeros((2, 2))
    gains = unheard_gains(T_S, variances)
    for gain in gains[:200]:
        P = F @ P @ F.T + Q
        K = P @ np.linalg.inv(P + R)
        P = (np.eye(2) - K) @ P
        assert np.array(gain) == pytest.approx(K, abs=1e-12)
    assert gains[0][1][1] < 1e-3  # at first nothing but the motion that was heard counts


@given(st.floats(-50.0, 50.0), st.floats(-5.0, 5.0), ACCELERATION, st.floats(0.0, 5.0))
def test_odometers_and_offsets_agree_with_uniform_acceleration(
    p: float, v: float, a: float, t: float
) -> None:
    start = Odometer(p, v)
    end = moved(start, t, (0.5 * a * t * t, a * t))
    assert end == pytest.approx((p + v * t + 0.5 * a * t * t, v + a * t))
    assert coasted(start, t) == moved(start, t, (0.0, 0.0))
    state = Relative(37.5, 1.5)
    offset = offset_of(state, start, end)
    assert state_of(offset, 0.0, start, end) == pytest.approx(state)
    assert state_of(offset, 2.0, start, end) == pytest.approx((37.5 + 2.0 * offset.v, 1.5))
