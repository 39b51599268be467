"""A decision applies the law of its mode to readings or predictions."""

from __future__ import annotations

import pytest

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Relative, Setpoint, builtin, law_of
from zenvoy.scenarios import Limits
from zenvoy.vehicles.decision import Aim, Controller, Decision, Position, Predicted, View
from zenvoy.vehicles.decision import decide as decide_by

WANTED = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0)
AIM = Aim(WANTED, Limits(-3.0, 3.0))
READ = View(
    radar=Relative(40.5, 0.0), ahead=Relative(40.5, 0.0), behind=Relative(35.5, 0.0), speed=30.0
)
PREDICTED = Predicted(ahead=Relative(39.5, 1.0), behind=Relative(36.5, 0.0), speed=28.0)


def decide(
    model: str, position: Position, read: View, predicted: Predicted | None, aim: Aim = AIM
) -> Decision:
    law = law_of(model)
    controller = Controller(law, law.parameters(), law.mode or 0)
    return decide_by(controller, position, read, predicted, aim)


MODELS = list(builtin())
UNBOUNDED = ["FM", "BCM", "MBCM", "PBCM", "CACC"]  # more gap, more acceleration
DEAF = READ._replace(behind=None)

FM_READ = 0.3  # 0.1 · (40.5 - 37.5)
BCM_READ = 0.5  # 0.1 · (40.5 - 35.5)
FM_PREDICTED = 0.8  # 0.1 · 2 + 0.5 · 1 + 0.05 · 2
BCM_PREDICTED = 0.9  # 0.1 · 3 + 0.5 · 1 + 0.05 · 2


@pytest.mark.parametrize(
    ("model", "place", "read", "predicted", "a", "mode"),
    [
        ("FM", Position.MIDDLE, READ, None, FM_READ, pb.MODE_FM),
        ("FM", Position.MIDDLE, DEAF, None, FM_READ, pb.MODE_FM),
        ("FM", Position.MIDDLE, READ, PREDICTED, FM_READ, pb.MODE_FM),
        ("FM", Position.LAST, DEAF, None, FM_READ, pb.MODE_FM),
        ("BCM", Position.MIDDLE, READ, None, BCM_READ, pb.MODE_BCM),
        ("PBCM", Position.MIDDLE, READ, PREDICTED, BCM_PREDICTED, pb.MODE_PBCM),
        # Data on the vehicle behind are missing or too old: the own radar serves, unfiltered.
        ("BCM", Position.MIDDLE, DEAF, None, FM_READ, pb.MODE_FALLBACK_FM),
        ("PBCM", Position.MIDDLE, DEAF, PREDICTED, FM_READ, pb.MODE_FALLBACK_FM),
        (
            "PBCM",
            Position.MIDDLE,
            READ,
            PREDICTED._replace(behind=None),
            FM_READ,
            pb.MODE_FALLBACK_FM,
        ),
        # The ends of the open road, paper Eq. 5: no data are missing there.
        ("BCM", Position.LAST, DEAF, None, FM_READ, pb.MODE_BCM),
        ("PBCM", Position.LAST, DEAF, PREDICTED._replace(behind=None), FM_PREDICTED, pb.MODE_PBCM),
    ],
)
def test_each_mode_has_its_decision(
    model: str,
    place: Position,
    read: View,
    predicted: Predicted | None,
    a: float,
    mode: pb.Mode.ValueType,
) -> None:
    decision = decide(model, place, read, predicted)
    assert decision.acceleration == pytest.approx(a, abs=1e-12)
    assert decision.mode == mode


@pytest.mark.parametrize("model", MODELS)
def test_the_first_vehicle_of_the_open_road_keeps_its_speed(model: str) -> None:
    for view in (READ, View(radar=None, ahead=None, behind=READ.behind, speed=20.0)):
        decision = decide(model, Position.FIRST, view, PREDICTED)
        assert decision[:3] == (0.0, pb.MODE_CONSTANT_SPEED, 0)


@pytest.mark.parametrize("place", [Position.MIDDLE, Position.LAST])
@pytest.mark.parametrize("model", UNBOUNDED)
@pytest.mark.parametrize("behind", [None, Relative(37.5, 0.0)])
def test_no_decision_exceeds_the_limit(
    model: str, place: Position, behind: Relative | None
) -> None:
    for gap, limit in ((5.0, -3.0), (1_000.0, 3.0)):
        ahead = Relative(gap, 0.0)
        view = View(
            radar=ahead,
            ahead=ahead,
            behind=behind,
            speed=30.0,
            sides=((ahead, behind),) if behind else (),
            predecessor=Motion(30.0, 2 * limit),
            leader=Motion(30.0, 2 * limit),
        )
        predicted = Predicted(ahead, behind, 30.0)
        assert decide(model, place, view, predicted).acceleration == limit


SIDES = ((Relative(40.5, 0.0), Relative(35.5, 0.0)), (Relative(80.0, 0.0), Relative(70.0, 0.0)))


def assert_decides(
    model: str,
    view: View,
    a: float,
    mode: pb.Mode.ValueType,
    m: int = 0,
    at: Position = Position.MIDDLE,
) -> None:
    decision = decide(model, at, view, None)
    assert decision.acceleration == pytest.approx(a, abs=1e-12)
    assert (decision.mode, decision.neighbours) == (mode, m)


def test_mbcm_uses_neighbours_with_data_on_both_sides() -> None:
    # weights 1/5 and 4/5 of 0.1 · 5 and 0.1 · 10
    assert_decides("MBCM", READ._replace(sides=SIDES), 0.9, pb.MODE_MBCM, 2)
    assert_decides("MBCM", READ._replace(sides=SIDES[:1]), BCM_READ, pb.MODE_MBCM, 1)
    assert_decides("MBCM", READ, FM_READ, pb.MODE_FALLBACK_FM)
    assert_decides("MBCM", READ, FM_READ, pb.MODE_MBCM, at=Position.LAST)


def test_cacc_needs_the_predecessor_and_the_leader() -> None:
    view = READ._replace(predecessor=Motion(30.0, 0.4), leader=Motion(29.0, 0.2))
    # 0.5 · 0.4 + 0.5 · 0.2 - 0.1 · 1 + 0.04 · 3
    assert_decides("CACC", view, 0.32, pb.MODE_CACC)
    assert_decides("CACC", view, 0.32, pb.MODE_CACC, at=Position.LAST)
    assert_decides("CACC", view._replace(predecessor=None), FM_READ, pb.MODE_FALLBACK_FM)
    assert_decides("CACC", view._replace(leader=None), FM_READ, pb.MODE_FALLBACK_FM)


def test_without_reported_positions_the_own_radar_is_used() -> None:
    """With neighbour_state position the link ahead also comes from a beacon."""
    for model in ("FM", "BCM", "CACC"):
        assert_decides(model, READ._replace(ahead=None), FM_READ, pb.MODE_FALLBACK_FM)
