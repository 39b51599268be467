"""Gains and laws to which linear theory is applied."""

from __future__ import annotations

from typing import Final

from hypothesis import strategies as st

from zenvoy.analysis.theory.laws import BCM, FM, mbcm
from zenvoy.laws.library.mbcm import weights_of
from zenvoy.scenarios import Gains

PAPER: Final = Gains()  # k_d 0.1, k_v 0.5, k_c 0.05
MBCM3: Final = mbcm(weights_of("least-squares", 3))
GAINS: Final = st.builds(
    Gains, k_d=st.floats(0.02, 1.0), k_v=st.floats(0.0, 2.0), k_c=st.floats(0.01, 1.0)
)
COUPLINGS: Final = st.sampled_from(
    [FM, BCM, MBCM3, mbcm(weights_of("uniform", 2)), mbcm((0.7, 0.2, 0.1, 0.05))]
)
