"""Which law is applied to what, in which mode."""

from __future__ import annotations

import pytest

from zenvoy.bus import messages_pb2 as pb
from zenvoy.vehicles.controllers import Law
from zenvoy.vehicles.decision import Place, View, decide
from zenvoy.vehicles.relative import Relative

LAW = Law(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0, a_max=3.0)
READ = View(ahead=Relative(40.5, 0.0), behind=Relative(35.5, 0.0), speed=30.0)
PREDICTED = View(ahead=Relative(39.5, 1.0), behind=Relative(36.5, 0.0), speed=28.0)
DEAF = READ._replace(behind=None)

FM_READ = 0.3  # 0.1 · (40.5 - 37.5)
BCM_READ = 0.5  # 0.1 · (40.5 - 35.5)
FM_PREDICTED = 0.8  # 0.1 · 2 + 0.5 · 1 + 0.05 · 2
BCM_PREDICTED = 0.9  # 0.1 · 3 + 0.5 · 1 + 0.05 · 2


@pytest.mark.parametrize(
    ("model", "place", "read", "predicted", "a", "mode"),
    [
        ("FM", Place.MIDDLE, READ, None, FM_READ, pb.MODE_FM),
        ("FM", Place.MIDDLE, DEAF, None, FM_READ, pb.MODE_FM),
        ("FM", Place.MIDDLE, READ, PREDICTED, FM_READ, pb.MODE_FM),
        ("FM", Place.LAST, DEAF, None, FM_READ, pb.MODE_FM),
        ("BCM", Place.MIDDLE, READ, None, BCM_READ, pb.MODE_BCM),
        ("PBCM", Place.MIDDLE, READ, PREDICTED, BCM_PREDICTED, pb.MODE_PBCM),
        # Nothing of the vehicle behind, or too old: the own radar, as it is.
        ("BCM", Place.MIDDLE, DEAF, None, FM_READ, pb.MODE_FALLBACK_FM),
        ("PBCM", Place.MIDDLE, DEAF, PREDICTED, FM_READ, pb.MODE_FALLBACK_FM),
        (
            "PBCM",
            Place.MIDDLE,
            READ,
            PREDICTED._replace(behind=None),
            FM_READ,
            pb.MODE_FALLBACK_FM,
        ),
        # The ends of the open road, paper Eq. 5: nobody is missed there.
        ("BCM", Place.LAST, DEAF, None, FM_READ, pb.MODE_BCM),
        ("PBCM", Place.LAST, DEAF, PREDICTED._replace(behind=None), FM_PREDICTED, pb.MODE_PBCM),
    ],
)
def test_decisions(
    model: str,
    place: Place,
    read: View,
    predicted: View | None,
    a: float,
    mode: pb.Mode.ValueType,
) -> None:
    decision = decide(model, place, read, predicted, LAW)
    assert decision.acceleration == pytest.approx(a, abs=1e-12)
    assert decision.mode == mode


@pytest.mark.parametrize("model", ["FM", "BCM", "PBCM"])
def test_the_first_of_the_open_road_keeps_its_speed(model: str) -> None:
    for view in (READ, View(ahead=None, behind=READ.behind, speed=20.0)):
        decision = decide(model, Place.FIRST, view, view, LAW)
        assert decision == (0.0, pb.MODE_CONSTANT_SPEED)


@pytest.mark.parametrize("place", [Place.MIDDLE, Place.LAST])
@pytest.mark.parametrize("model", ["FM", "BCM", "PBCM"])
@pytest.mark.parametrize("behind", [None, Relative(37.5, 0.0)])
def test_no_decision_is_beyond_the_limit(model: str, place: Place, behind: Relative | None) -> None:
    for gap, limit in ((5.0, -3.0), (1_000.0, 3.0)):
        view = View(ahead=Relative(gap, 0.0), behind=behind, speed=30.0)
        assert decide(model, place, view, view, LAW).acceleration == limit
