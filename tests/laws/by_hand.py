"""The setpoint and the state of rest of laws that are computed by hand."""

from __future__ import annotations

from typing import Final

from zenvoy.laws import Relative, Setpoint

WANTED: Final = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0)
REST: Final = Relative(37.5, 0.0)
