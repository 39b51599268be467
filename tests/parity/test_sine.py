"""Behind a leader that oscillates, Zenvoy's laws move as those of SUMO's model CC."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.parity.cases import LAWS
from tests.parity.figures import compared, ratios_of_speeds, swings_of_gaps
from tests.parity.printed import ratios, swings
from tests.parity.tables import Compared, differences_from_page

EQUAL = [law.name for law in LAWS if law.name != "CACC, acted"]


def of_laws(figure: str) -> dict[str, Compared]:
    measure = {"swings": swings_of_gaps, "ratios": ratios_of_speeds}[figure]
    return {one.law: one for one in compared(measure, "sine")}


@pytest.mark.parametrize("law", EQUAL)
@pytest.mark.parametrize("figure", ["swings", "ratios"])
def test_laws_are_within_5_percent_of_sumo(law: str, figure: str) -> None:
    assert np.abs(of_laws(figure)[law].difference).max() < 0.05


def test_reports_of_mean_accelerations_lead_those_of_sumo() -> None:
    """The report is 68 ms ahead of SUMO's; with equal reports, gaps are within 1 %."""
    of = of_laws("swings")
    acted, expected = of["CACC, acted"].difference, of["CACC, expected"].difference
    assert (acted < -0.08).all()
    assert np.abs(expected).max() < 0.01


def test_sumo_has_the_figures_that_are_known_of_it() -> None:
    swung, ratio = of_laws("swings")["CACC"].sumo, of_laws("ratios")["Ploeg"].sumo
    assert swung == pytest.approx([0.077, 0.067, 0.034, 0.018, 0.010, 0.006, 0.004], abs=5.1e-4)
    assert ratio[0] == pytest.approx(0.854, abs=6e-4)
    assert 0.8735 < ratio[1:].min() < ratio[1:].max() < 0.8856


@pytest.mark.parametrize("printed", [swings, ratios])
def test_the_page_has_the_printed_table(printed: Callable[[], list[str]]) -> None:
    assert differences_from_page(printed()) == []
