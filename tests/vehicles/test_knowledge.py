"""What a vehicle makes of what it reads and hears, seen from outside: beacons and commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE, Topic
from zenvoy.scenarios import Control, Fleet, Gains, Model, Road, Scenario, Sensors, Switch
from zenvoy.vehicles.lock_step import LockStepVehicle

T_NS = 100_000_000
T_S = 0.1
AHEAD, HOST, BEHIND = 2, 3, 4
USUAL = Gains()
STILL = Gains(k_d=0.0, k_v=0.0, k_c=0.0)  # commands nothing whatever it knows


def scenario(
    *,
    model: Model = "PBCM",
    gains: Gains = USUAL,
    wait_ms: float = 11.0,
    delay_ms: float = 89.0,
    age_limit_ms: float = 1_000.0,
    open_road: bool = False,
) -> Scenario:
    return Scenario(
        duration_s=10.0,
        road=Road(type="open" if open_road else "ring"),
        fleet=Fleet(size=5),
        sensors=Sensors(error=0.0),
        control=Control(
            model=model,
            gains=gains,
            v2v_wait_ms=wait_ms,
            system_delay_ms=delay_ms,
            beacon_age_limit_ms=age_limit_ms,
        ),
    )


class Cab:
    """Drives one agent by hand-made messages, cycle by cycle."""

    def __init__(self, settings: Scenario, vehicle: int = HOST) -> None:
        self.agent = LockStepVehicle(settings, vehicle)
        self.vehicle = vehicle
        self.cycle = -1
        self._mailbox = Mailbox()

    def sense(
        self,
        *,
        gap: float | None = 37.5,
        relative_speed: float = 0.0,
        speed: float = 30.0,
        acceleration: float = 0.0,
    ) -> pb.Beacon:
        """Begin a cycle; returns what the vehicle puts on the air."""
        self.cycle += 1
        message = pb.Sense(
            cycle=self.cycle,
            time_ns=self.cycle * T_NS,
            vehicle=self.vehicle,
            ahead=None if gap is None else pb.Link(gap=gap, speed=relative_speed),
            position=1_000.0,
            speed=speed,
            acceleration=acceleration,
        )
        return BEACON.decode(self._step(SENSE, message.SerializeToString(), BEACON))

    def receive(self, beacons: Sequence[pb.Beacon] = ()) -> pb.Command:
        """End the cycle; returns what the vehicle decides."""
        barrier = self.agent.barrier
        assert barrier is not None
        message = pb.Receive(
            cycle=self.cycle,
            time_ns=barrier.now_ns,
            vehicle=self.vehicle,
            source=[beacon.vehicle for beacon in beacons],
            arrived_ns=[barrier.now_ns] * len(beacons),
            beacon=[beacon.SerializeToString() for beacon in beacons],
        )
        command = COMMAND.decode(self._step(RECEIVE, message.SerializeToString(), COMMAND))
        assert (command.cycle, command.time_ns) == (self.cycle, barrier.now_ns)
        return command

    def _step(self, topic: Topic[Any], payload: bytes, answers: Topic[Any]) -> bytes:
        """Hand in the one message that the agent waits for; returns the one that it answers."""
        barrier, mailbox = self.agent.barrier, self._mailbox
        assert barrier is not None
        mailbox.put(topic, self.vehicle, payload)
        assert mailbox.met(barrier)
        (envelope,) = self.agent.step(barrier.now_ns, mailbox.take(barrier))
        assert (envelope.topic, envelope.vehicle) == (answers, self.vehicle)
        return envelope.payload


def beacon(
    vehicle: int,
    cycle: int,
    *,
    gap: float = 37.5,
    relative_speed: float = 0.0,
    speed: float = 30.0,
    acceleration: float = 0.0,
) -> pb.Beacon:
    """Of a vehicle that expects to go on as it does."""
    return pb.Beacon(
        cycle=cycle,
        time_ns=cycle * T_NS,
        vehicle=vehicle,
        sequence=cycle,
        speed=speed,
        acceleration=acceleration,
        ahead=pb.Link(gap=gap, speed=relative_speed),
        planned_from_ns=[cycle * T_NS],
        planned_acceleration=[acceleration],
    )


def assert_plans(told: pb.Beacon, *plan: tuple[int, float]) -> None:
    """What a beacon says will be: from when (ms) and how much (m/s²)."""
    assert [t / 1e6 for t in told.planned_from_ns] == [t for t, _ in plan]
    assert list(told.planned_acceleration) == pytest.approx([a for _, a in plan], abs=1e-12)


# --- what it tells ---


def test_a_beacon_carries_what_was_sensed() -> None:
    cab = Cab(scenario())
    cab.sense()
    cab.receive()
    told = cab.sense(gap=31.0, relative_speed=-1.5, speed=28.0, acceleration=0.05)
    assert (told.vehicle, told.cycle, told.sequence, told.time_ns) == (HOST, 1, 1, T_NS)
    assert (told.position, told.speed, told.acceleration) == (1_000.0, 28.0, 0.05)
    assert (told.ahead.gap, told.ahead.speed) == (31.0, -1.5)
    assert not Cab(scenario(open_road=True), 1).sense(gap=None).HasField("ahead")


def test_a_beacon_tells_the_commands_that_are_not_yet_in_effect() -> None:
    """Decided 11 ms into a cycle, in effect 280 ms into it: three are on their way at once."""
    cab = Cab(scenario(model="FM", wait_ms=11, delay_ms=269))
    decided: list[float] = []
    for cycle in range(8):
        # What acted in the cycle before: 80 ms of one command, then 20 ms of the next.
        older = decided[cycle - 4] if cycle >= 4 else 0.0
        newer = decided[cycle - 3] if cycle >= 3 else 0.0
        told = cab.sense(gap=40.0 + cycle, acceleration=0.8 * older + 0.2 * newer)
        on_the_way = [(100 * k + 280, decided[k]) for k in range(max(0, cycle - 2), cycle)]
        in_force = decided[cycle - 3] if cycle >= 3 else 0.0
        assert_plans(told, (100 * cycle, in_force), *on_the_way)
        command = cab.receive()
        assert command.effective_ns == cycle * T_NS + 280_000_000
        decided.append(command.acceleration)
    assert len(set(decided)) == 8


@pytest.mark.parametrize("read", [-3.0, 0.2, 2.0])
def test_a_reading_that_contradicts_the_commands_replaces_the_plan(read: float) -> None:
    cab = Cab(scenario(model="FM", delay_ms=189, gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    for _ in range(4):
        cab.sense(gap=42.5)
        assert cab.receive().acceleration == pytest.approx(0.5)
    told = cab.sense(gap=42.5, acceleration=read)
    assert_plans(told, (400, read))
    cab.receive()
    told = cab.sense(gap=42.5, acceleration=0.5)  # as commanded again
    assert_plans(told, (500, 0.5), (600, 0.5))


def test_a_reading_about_as_commanded_leaves_the_plan() -> None:
    cab = Cab(scenario(model="FM", gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    cab.sense(gap=42.5)
    cab.receive()
    cab.sense(gap=42.5)
    cab.receive()
    assert_plans(cab.sense(acceleration=0.42), (200, 0.5))


# --- what it hears ---


def test_disorder_duplicates_and_strangers_change_nothing() -> None:
    """The same news, once in order and once with everything a channel may add to it."""
    orderly, other = Cab(scenario()), Cab(scenario())
    fronts = [
        beacon(AHEAD, k, speed=30.0 - 0.1 * k, acceleration=-1.0 + 0.1 * k) for k in range(12)
    ]
    rears = [
        beacon(BEHIND, k, gap=36.0 + 0.2 * k, relative_speed=0.3, acceleration=0.1 * k)
        for k in range(12)
    ]
    strangers = [beacon(1 + 4 * (k % 2), k // 2, gap=6.0, acceleration=3.0) for k in range(24)]
    for k in range(12):
        for cab in (orderly, other):
            cab.sense(gap=37.0 + 0.1 * k, speed=30.0, acceleration=0.0)
        news: list[pb.Beacon] = []  # in every third cycle nothing gets through
        if k % 3 == 1:
            news = [*fronts[max(0, k - 1) : k + 1], *rears[max(0, k - 1) : k + 1]]
        elif k % 3 == 2:
            news = [fronts[k], rears[k]]
        replayed = [*fronts[: max(0, k - 2)], *rears[: max(0, k - 2)]]
        decided = orderly.receive(news)
        mixed_up = other.receive([*news[::-1], *replayed, *strangers[: 2 * k], *news])
        assert mixed_up.SerializeToString() == decided.SerializeToString()
        if k > 0:
            assert decided.behind.measured_ns == (k if k % 3 else k - 1) * T_NS


def senseless() -> list[pb.Beacon]:
    """Beacons of the vehicle behind that no honest one sends."""
    later = beacon(BEHIND, 50)
    torn = beacon(BEHIND, 2)
    torn.planned_from_ns.append(7 * T_NS)
    numbers = [
        beacon(BEHIND, 2, gap=math.nan),
        beacon(BEHIND, 2, relative_speed=math.inf),
        beacon(BEHIND, 2, speed=-math.inf),
        beacon(BEHIND, 2, acceleration=math.nan),
    ]
    return [later, torn, *numbers]


@pytest.mark.parametrize("nonsense", senseless())
def test_a_beacon_that_makes_no_sense_is_as_good_as_lost(nonsense: pb.Beacon) -> None:
    deaf, other = Cab(scenario()), Cab(scenario())
    for k in range(5):
        news = [] if k == 2 else [beacon(AHEAD, k), beacon(BEHIND, k, gap=36.0)]
        for cab in (deaf, other):
            cab.sense()
        wrong = [nonsense] if k == 2 else []
        assert other.receive([*news, *wrong]) == deaf.receive(news)


def test_a_late_frame_is_taken_at_its_own_time() -> None:
    cab = Cab(scenario(gains=STILL))
    for k in range(3):
        cab.sense()
        cab.receive([beacon(BEHIND, k)])
    cab.sense()
    assert cab.receive().behind.measured_ns == 2 * T_NS
    cab.sense()
    # It was sent in cycle 3, when the gap was 50 m and grew by 10 m/s; 0.2 s are to be predicted.
    late = cab.receive([beacon(BEHIND, 3, gap=50.0, relative_speed=10.0)])
    assert late.behind.measured_ns == 3 * T_NS
    assert late.age_ns == T_NS
    v = late.behind.speed
    assert late.behind.predicted_gap == pytest.approx(late.behind.gap + 0.2 * v, abs=1e-9)
    assert v > 8.0


def test_of_the_neighbours_readings_the_newest_one_counts_for_bcm() -> None:
    cab = Cab(scenario(model="BCM", gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    cab.sense(gap=40.0)
    cab.receive([beacon(BEHIND, 0, gap=30.0)])
    cab.sense(gap=40.0)
    command = cab.receive([beacon(BEHIND, 1, gap=35.0), beacon(BEHIND, 0, gap=20.0)])
    assert command.acceleration == pytest.approx(0.5)  # 0.1 · (40 - 35)
    assert command.mode == pb.MODE_BCM
    assert math.isnan(command.ahead.gap)
    assert math.isnan(command.predicted_speed)


# --- what it predicts ---


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
def test_predicts_constant_accelerations_exactly(
    own_a: float,
    ahead_a: float,
    behind_a: float,
    gaps: tuple[float, float],
    speeds: tuple[float, float, float],
    delay_ms: int,
    wait_ms: int,
    late: tuple[int, int],
) -> None:
    """Without noise: what it says of the instant of effect is what the closed form says.

    The host commands nothing, so what it does otherwise contradicts its commands and is believed
    to go on. Each neighbour's frames are `late` by that many cycles.
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


def test_predicts_with_the_commands_that_are_on_their_way() -> None:
    """Its own commands act as commanded, 300 ms after the cycle's start."""
    cab = Cab(scenario(delay_ms=289, wait_ms=11, gains=Gains(k_d=0.02, k_v=0.1, k_c=0.05)))
    steps: list[tuple[float, float]] = []  # (from, a) of the host; the neighbours keep 30 m/s

    def host(t: float) -> tuple[float, float, float]:
        """Position, speed and acceleration by exact integration of the commands."""
        p, v, now, a = 0.0, 25.0, 0.0, 0.0
        for start, value in steps:
            if start >= t:
                break
            p += v * (start - now) + 0.5 * a * (start - now) ** 2
            v, now, a = v + a * (start - now), start, value
        return p + v * (t - now) + 0.5 * a * (t - now) ** 2, v + a * (t - now), a

    for k in range(25):
        t = k * T_S
        p, v, _ = host(t)
        before = host(max(0.0, t - T_S))[1]
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
        p, v, _ = host(effect)
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


def test_no_speed_is_predicted_below_standstill() -> None:
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


# --- when nothing is heard ---


@pytest.mark.parametrize("model", ["BCM", "PBCM"])
def test_past_the_age_limit_it_follows_its_radar_until_it_hears_again(model: Model) -> None:
    cab = Cab(scenario(model=model, age_limit_ms=300, gains=Gains(k_d=0.1, k_v=0.5, k_c=0.05)))
    mode = pb.MODE_BCM if model == "BCM" else pb.MODE_PBCM
    for k in range(14):
        cab.sense(gap=40.5, speed=28.0)
        heard = [beacon(BEHIND, k, gap=38.0)] if k in {2, 3, 11, 12, 13} else []
        command = cab.receive(heard)
        if k < 2:
            assert (command.mode, command.age_ns) == (pb.MODE_FALLBACK_FM, -1)
        elif k <= 6 or k >= 11:  # at the limit it is not past it
            assert command.mode == mode
            assert command.age_ns == ((k - 3) * T_NS if 3 <= k <= 6 else 0)
        else:
            assert (command.mode, command.age_ns) == (pb.MODE_FALLBACK_FM, (k - 3) * T_NS)
        if command.mode == pb.MODE_FALLBACK_FM:  # 0.1 · 3 + 0.05 · 2
            assert command.acceleration == pytest.approx(0.4, abs=1e-12)


def test_the_schedule_switches_models_at_the_first_decision_from_then_on() -> None:
    """Decisions fall 11 ms into each cycle; two switches before the same one count as the last."""
    control = Control(
        model="FM",
        schedule=(
            Switch(at_s=0.311, model="BCM"),
            Switch(at_s=0.512, model="FM"),
            Switch(at_s=0.55, model="PBCM"),
        ),
    )
    cab = Cab(Scenario(duration_s=10.0, fleet=Fleet(size=5), control=control))
    modes = []
    for k in range(8):
        cab.sense()
        modes.append(cab.receive([beacon(BEHIND, k)]).mode)
    assert modes == [pb.MODE_FM] * 3 + [pb.MODE_BCM] * 3 + [pb.MODE_PBCM] * 2


def test_fm_needs_nobody() -> None:
    cab = Cab(scenario(model="FM"))
    for _ in range(15):
        cab.sense(gap=40.5)
        command = cab.receive()
        assert command.mode == pb.MODE_FM
        assert command.acceleration == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize("model", ["FM", "BCM", "PBCM"])
def test_the_ends_of_the_open_road(model: Model) -> None:
    settings = scenario(model=model, open_road=True, age_limit_ms=300)
    first, last = Cab(settings, 1), Cab(settings, 5)
    for k in range(8):
        first.sense(gap=None, speed=20.0)
        last.sense(gap=40.5)
        led = first.receive([beacon(2, k, gap=20.0)])
        assert (led.acceleration, led.mode) == (0.0, pb.MODE_CONSTANT_SPEED)
        followed = last.receive([beacon(4, k)])
        assert (
            followed.mode
            == {
                "FM": pb.MODE_FM,
                "BCM": pb.MODE_BCM,
                "PBCM": pb.MODE_PBCM,
            }[model]
        )
        assert followed.acceleration == pytest.approx(0.3, abs=1e-9 if model != "PBCM" else 0.05)


def test_nobody_is_behind_the_last_of_the_open_road() -> None:
    """The first one, a road's length ahead, may well be heard; it is nobody's follower."""
    last = Cab(scenario(open_road=True), 5)
    first = beacon(1, 0)
    first.ClearField("ahead")
    last.sense()
    command = last.receive([first])
    assert command.age_ns == -1
    assert command.behind.measured_ns == -1
