"""A user's own law: the text of a file `idm.py` that defines `smith`."""

from __future__ import annotations

from typing import Final

# The Intelligent Driver Model (Treiber, Hennecke and Helbing, 2000).
IDM: Final = """
from dataclasses import dataclass

from zenvoy.laws import Law, root


@dataclass(frozen=True)
class Parameters:
    headway_s: float = 1.2
    a: float = 1.4
    b: float = 2.0
    s0: float = 2.0


def idm(seen, p):
    v, gap = seen.speed, seen.ahead.p - 5.0
    wanted = p.s0 + v * p.headway_s - v * seen.ahead.v / (2.0 * root(p.a * p.b))
    free = v / seen.setpoint.v_des
    return p.a * (1.0 - free * free * free * free - (wanted / gap) * (wanted / gap))


smith = Law(name="Smith", acceleration=idm, parameters=Parameters, colour="#CC79A7")
"""
