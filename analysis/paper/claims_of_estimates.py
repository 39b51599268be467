"""The claims of Section IV-B on the errors of estimates."""

from __future__ import annotations

import math
from functools import partial
from typing import Final

import numpy as np

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.statistics import Mean
from zenvoy.analysis.paper.claim import Answer, claim
from zenvoy.analysis.paper.evidence import Evidence, agreed

# Table VI: R² and RMSE (m/s) of measured values, then of estimated values.
TABLE_6: Final = {
    "13": ((0.75, 1.25), (0.98, 0.47)),
    "14": ((0.73, 1.18), (0.97, 0.44)),
    "15": ((0.53, 1.44), (0.96, 0.62)),
    "16": ((0.51, 1.52), (0.94, 0.65)),
}


@claim(
    where="Table VI",
    says="Estimation lowers the RMSE of the speed: 1.25 to 0.47, 1.18 to 0.44, 1.44 to 0.62,"
    " 1.52 to 0.65 m/s in cases 13 to 16",
    needs_s=100,
)
def errors_reduced(evidence: Evidence) -> Answer:
    measured, estimated = (
        {
            label: evidence.over(label, partial(agreed, what=f"{what}_speed", name="rmse"))
            for label in TABLE_6
        }
        for what in ("measured", "estimated")
    )
    ours = "; ".join(
        f"case {label}: {measured[label].text(3)} to {estimated[label].text(3, 'm/s')}"
        for label in TABLE_6
    )
    ratios = {label: estimated[label].mean / measured[label].mean for label in TABLE_6}
    theirs = {label: after[1] / before[1] for label, (before, after) in TABLE_6.items()}
    better = all(ratios[label] < theirs[label] for label in TABLE_6)
    return Answer(
        ours=ours,
        verdict="stronger" if better else "weaker",
        why=f"The RMSE falls to {min(ratios.values()):.2f} to {max(ratios.values()):.2f} of that of"
        f" the readings, in the paper to {min(theirs.values()):.2f} to"
        f" {max(theirs.values()):.2f}. Our filter's input is the actual acceleration, from the own"
        " sensor and the neighbours' beacons.",
    )


@claim(
    where="Table VI",
    says="Estimation raises R² of the speed: 0.75 to 0.98, 0.73 to 0.97, 0.53 to 0.96, 0.51 to"
    " 0.94",
    needs_s=60,
)
def r2(evidence: Evidence) -> Answer:
    def of(what: int) -> dict[str, Mean]:
        return {
            label: evidence.over(label, lambda run: _r2_of_link(run, what)) for label in TABLE_6
        }

    measured, estimated = of(1), of(2)
    ours = "; ".join(
        f"case {label}: {measured[label].text(3)} to {estimated[label].text(3)}"
        for label in TABLE_6
    )
    low = min(value.mean for value in estimated.values())
    return Answer(
        ours=f"{ours} (vehicle 5, first 60 s)",
        verdict="confirmed" if low >= 0.94 else "weaker",
        why="R² compares the error with the variation of the true speed, so it depends on the"
        " trajectory as much as on the filter. The paper does not name its trajectory. We take the"
        " vehicle that brakes, in the minute of the disturbance. At 3 % this gives the paper's"
        " values. At 10 % the error of readings is 1.73 m/s, not 1.44 as in the paper, and their R²"
        " is below 0. Over the whole fleet and 500 s, speeds hardly vary under PBCM, so R² is low"
        " with the same errors (Table VI in README.md).",
    )


@claim(
    where="Table VI",
    says="R² and RMSE of measured and of estimated speeds, of the same runs",
    needs_s=60,
)
def one_trajectory(evidence: Evidence) -> Answer:
    spread = {
        label: [rmse / math.sqrt(1.0 - r2) for r2, rmse in both] for label, both in TABLE_6.items()
    }
    pairs = "; ".join(f"case {label}: {a:.2f} and {b:.2f}" for label, (a, b) in spread.items())
    agree = all(abs(a - b) <= 0.05 * a for a, b in spread.values())
    true = evidence.over("15", lambda run: float(run.link[0].std()))
    return Answer(
        ours=f"R² = 1 - RMSE²/σ² needs one σ of the true speed per case; the printed pairs need"
        f" {pairs} m/s. The speed of the vehicle that brakes has σ = {true.text(2, 'm/s')} in"
        " case 15.",
        verdict="confirmed" if agree else "contradicts itself",
        why="Readings and estimates of one trajectory share its variance, but the printed values"
        " imply two different variances per case.",
    )


@claim(
    where="Table VI",
    says="With the error at 10 % instead of 3 % the RMSE of measured speeds is 1.44 instead of"
    " 1.25 m/s: 15 % more",
    needs_s=10,
)
def error_growth(evidence: Evidence) -> Answer:
    rmse = {
        label: evidence.over(label, partial(agreed, what="measured_speed", name="rmse"))
        for label in ("13", "15")
    }
    ratio = rmse["15"].mean / rmse["13"].mean
    return Answer(
        ours=f"{rmse['15'].text(3)} against {rmse['13'].text(3, 'm/s')}: {ratio:.2f} times",
        verdict="confirmed" if ratio < 1.3 else "contradicts itself",
        why="A relative error grows with its percentage, here 10/3 times. At 30 m/s and uniform"
        f" errors of ±3 % the RMSE is {0.03 * 30 / math.sqrt(3):.2f} m/s, of ±10 %"
        f" {0.1 * 30 / math.sqrt(3):.2f} m/s.",
    )


def _r2_of_link(run: Digest, row: int, span_s: float = 60.0) -> float:
    rows = np.flatnonzero(run.time_s[: run.link.shape[1]] < span_s)
    true, values = run.link[0][rows], run.link[row][rows]
    return 1.0 - float(((values - true) ** 2).sum() / ((true - true.mean()) ** 2).sum())


CLAIMS: Final = (
    errors_reduced,
    r2,
    one_trajectory,
    error_growth,
)
