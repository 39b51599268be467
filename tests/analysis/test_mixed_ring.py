"""Growth on a ring of mixed laws agrees with closed forms where all vehicles are alike."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest

from zenvoy.analysis.theory.laws import BCM, FM, Coupling, mbcm
from zenvoy.analysis.theory.mixed_ring import Driver, Equilibrium, growth_of, growth_per_s
from zenvoy.analysis.theory.ring import slowest_mode
from zenvoy.laws import Setpoint, law_of
from zenvoy.laws.library import idm
from zenvoy.laws.library.lcc import Parameters
from zenvoy.scenarios import Gains, load

SETPOINT: Final = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0)
AT: Final = Equilibrium(37.5, 30.0, 5.0)
N: Final = 14


def alike(
    name: str, at: Equilibrium = AT, setpoint: Setpoint = SETPOINT, own: object = None
) -> float:
    law = law_of(name)
    return growth_of([Driver(law, own or law.parameters(), setpoint)] * N, at)


@pytest.mark.parametrize(
    ("name", "coupling"),
    [("FM", FM), ("BCM", BCM), ("PBCM", BCM), ("MBCM", mbcm((1 / 14, 4 / 14, 9 / 14)))],
)
def test_vehicles_that_are_alike_have_the_modes_of_theory(name: str, coupling: Coupling) -> None:
    expected = slowest_mode(coupling, Gains(), N).rate
    # The fleet as a whole returns to its speed at -k_c, which is no wave of theory's.
    assert alike(name) == pytest.approx(max(expected, -0.05), abs=1e-6)


def test_drivers_have_the_modes_of_their_linear_form() -> None:
    own = idm.Parameters(acceleration_mps2=0.5)
    at = Equilibrium(idm.equilibrium_gap_m(own, 12.0) + 5.0, 12.0, 5.0)
    linear = law_of("IDM").linear
    assert linear is not None
    _, _, k_d, k_v, k_c = linear(own, SETPOINT._replace(v_des=12.0), 0)
    expected = slowest_mode(FM, Gains(k_d=k_d, k_v=k_v, k_c=k_c), N).rate
    assert expected > 0.001
    assert alike("IDM", at, SETPOINT, own) == pytest.approx(expected, abs=1e-6)


def test_lcc_alone_has_the_exponents_of_its_formula() -> None:
    """On a ring of LCC, mode n has θ = 2πn/N, and a vehicle ahead by j is ahead by e^(-iθj)."""
    own = Parameters()
    theta = 2.0 * np.pi * np.arange(N) / N
    ahead, behind = np.exp(-1j * theta), np.exp(1j * theta)
    gap = ahead - 1.0  # of a vehicle, from its own position
    position = own.alpha_1 * gap + own.mu_ahead * ahead * gap
    position = position + own.mu_behind * (behind + behind**2) * gap
    speed = -own.alpha_2 + (own.alpha_3 + own.k_ahead) * ahead
    speed = speed + own.k_behind * (behind + behind**2)
    roots = np.array([np.roots([1.0, -b, -c]) for b, c in zip(speed, position, strict=True)])
    expected = roots.real[np.abs(roots) > 1e-6].max()
    setpoint = SETPOINT._replace(p_des=AT.gap_m)
    assert alike("LCC", AT, setpoint) == pytest.approx(expected, abs=1e-6)
    assert expected > 0.0  # it is made to lead human drivers, not itself


@pytest.mark.parametrize(
    ("law", "share", "grows"),
    [("BCM", 0.2, True), ("BCM", 0.8, False), ("LCC", 0.05, False), ("LCC", 1.0, True)],
)
def test_shares_of_equipped_cars_stop_waves_or_not(law: str, share: float, grows: bool) -> None:
    changes = (f"fleet.groups.0.model={law}", f"fleet.groups.0.share={share}")
    assert (growth_per_s(load("ring/equipped", changes).scenario) > 0.0) == grows
