"""The age of beacons, the schedule and the ends of the open road select the model."""

from __future__ import annotations

import pytest

from tests.cab import BEHIND, T_NS, Cab, beacon, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Control, Fleet, Gains, Model, Scenario, Switch


@pytest.mark.parametrize("model", ["BCM", "PBCM"])
def test_past_the_age_limit_a_vehicle_follows_its_radar_until_it_hears_again(model: Model) -> None:
    cab = Cab(scenario(model=model, age_limit_ms=300, gains=Gains(k_d=0.1, k_v=0.5, k_c=0.05)))
    mode = pb.MODE_BCM if model == "BCM" else pb.MODE_PBCM
    for k in range(14):
        cab.sense(gap=40.5, speed=28.0)
        heard = [beacon(BEHIND, k, gap=38.0)] if k in {2, 3, 11, 12, 13} else []
        command = cab.receive(heard)
        if k < 2:
            assert (command.mode, command.age_ns) == (pb.MODE_FALLBACK_FM, -1)
        elif k <= 6 or k >= 11:  # the limit itself is not past it
            assert command.mode == mode
            assert command.age_ns == ((k - 3) * T_NS if 3 <= k <= 6 else 0)
        else:
            assert (command.mode, command.age_ns) == (pb.MODE_FALLBACK_FM, (k - 3) * T_NS)
        if command.mode == pb.MODE_FALLBACK_FM:  # 0.1 · 3 + 0.05 · 2
            assert command.acceleration == pytest.approx(0.4, abs=1e-12)


def test_the_schedule_switches_models_at_the_next_decision() -> None:
    """Decisions are 11 ms after each start. The last of several switches counts."""
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


def test_fm_needs_no_beacons() -> None:
    cab = Cab(scenario(model="FM"))
    for _ in range(15):
        cab.sense(gap=40.5)
        command = cab.receive()
        assert command.mode == pb.MODE_FM
        assert command.acceleration == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize("model", ["FM", "BCM", "PBCM"])
def test_models_at_the_ends_of_the_open_road(model: Model) -> None:
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


def test_nobody_is_behind_the_last_vehicle_of_the_open_road() -> None:
    """The last vehicle may hear the first, a road's length ahead, which is nobody's follower."""
    last = Cab(scenario(open_road=True), 5)
    first = beacon(1, 0)
    first.ClearField("ahead")
    last.sense()
    command = last.receive([first])
    assert command.age_ns == -1
    assert command.behind.measured_ns == -1
