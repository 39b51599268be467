"""PBCM: BCM on states predicted to the time at which the command takes effect (Eq. 8)."""

from __future__ import annotations

from zenvoy.laws.law import Law, Needs
from zenvoy.laws.library.bcm import bilateral, linear

LAW = Law(
    name="PBCM",
    acceleration=bilateral,
    needs=Needs(behind=True, prediction=True),
    keeps_gap=False,
    mode=5,
    colour="#0072B2",
    linear=linear,
)
