"""Behind a leader that brakes, Zenvoy's laws keep the gaps that SUMO's model CC keeps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.parity.cases import LAWS, THAT_COLLIDE, Limited
from tests.parity.figures import compared, smallest_gaps
from tests.parity.printed import braking, commands, engines
from tests.parity.tables import Compared, differences_from_page

EQUAL = [law.name for law in LAWS if law not in THAT_COLLIDE]


def of_laws(limited: Limited) -> dict[str, Compared]:
    return {one.law: one for one in compared(smallest_gaps, "braking", limited)}


@pytest.mark.parametrize("law", EQUAL)
def test_smallest_gaps_are_within_5_percent_of_sumo(law: str) -> None:
    assert np.abs(of_laws("nothing")[law].difference).max() < 0.05


def test_sumo_has_the_figures_that_are_known_of_it() -> None:
    of = of_laws("engines")
    assert of["CACC"].sumo[[0, 1, 2, -1]] == pytest.approx([2.83, 3.47, 4.10, 4.89], abs=6e-3)
    assert of["Ploeg"].sumo == pytest.approx(2.00, abs=6e-3)


@pytest.mark.parametrize("law", EQUAL)
def test_limited_commands_leave_the_gaps_that_they_leave_in_sumo(law: str) -> None:
    """GSBL's second vehicle stops within 10 cm, and 2 cm off. Ploeg's filter winds up."""
    of = of_laws("commands")[law]
    off = np.abs(of.difference)
    if law == "GSBL":
        assert abs(of.zenvoy[0] - of.sumo[0]) < 0.02
        off = off[1:]
    if law == "Ploeg":
        assert 0.1 < off[1] < 0.12
        off = np.delete(off, 1)
    assert off.max() < 0.05


def test_limited_engines_leave_other_gaps_than_limited_commands() -> None:
    """A law may command more than an engine can give, so the engine gives it all sooner."""
    of = of_laws("engines")
    assert of["CACC"].difference[0] < -0.2
    assert of["GSBL"].difference[0] < -0.9
    for law in ("ACC", "Consensus"):
        assert np.abs(of[law].difference).max() < 0.05


@pytest.mark.parametrize("printed", [braking, commands, engines])
def test_the_page_has_the_printed_table(printed: Callable[[], list[str]]) -> None:
    assert differences_from_page(printed()) == []
