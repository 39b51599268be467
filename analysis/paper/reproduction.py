"""Presents the paper's evaluation as tables, pictures and claims, from the evidence."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import Final

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.page.digits import columns
from zenvoy.analysis.page.section import Cell, Picture, Sheet
from zenvoy.analysis.paper import gains
from zenvoy.analysis.paper import pictures as figures
from zenvoy.analysis.paper.claim import Answer, Claim
from zenvoy.analysis.paper.claims import answers
from zenvoy.analysis.paper.claims_of_estimates import TABLE_6
from zenvoy.analysis.paper.evidence import (
    MODELS,
    PAIRS,
    Evidence,
    agreed,
    at,
    case,
    lowest,
    settled,
)

_MERITS: Final[dict[str, Callable[[Digest], float]]] = {
    "MinDistance before, m": lambda run: settled(run, "min_distance", 5.0, 10.0),
    "dip, m": lambda run: lowest(run, "min_distance", 10.0, 45.0),
    "MinDistance from 100 s, m": lambda run: settled(run, "min_distance", 100.0, 500.0),
    "MaxDistance from 100 s, m": lambda run: settled(run, "max_distance", 100.0, 500.0),
    "spread of speed at 100 s, m/s": lambda run: at(run, "spread", 100.0),
    "spread of speed from 100 s, m/s": lambda run: settled(run, "spread", 100.0, 500.0),
    "mean speed at the end, m/s": lambda run: settled(run, "mean_speed", 400.0, 500.0),
    "collisions": lambda run: run.facts["collisions"],
}


_AGREEMENTS: Final = (
    ("whole", "rmse"),
    ("whole", "r2"),
    ("disturbed", "r2"),
    ("disturbed", "r2_correlation"),
)


def sheets(evidence: Evidence) -> tuple[Sheet, ...]:
    """Return Table VI, the figures of every case on both roads, other gains, and fingerprints."""
    found = [_table_6(evidence), _cases(evidence, "", "cases", "The 16 cases on the ring.")]
    if any(label.startswith("open/") for label in evidence.runs):
        found.append(_cases(evidence, "open/", "cases-open", "The 16 cases on the open road."))
    if gains.has_gains(evidence):
        found.append(gains.sheet(evidence))
    return (*found, _fingerprints(evidence))


def _table_6(evidence: Evidence) -> Sheet:
    rows: list[tuple[Cell, ...]] = []
    for label, ((r2, rmse), (r2_estimated, rmse_estimated)) in TABLE_6.items():
        for what, of_paper in (
            ("measured", (rmse, r2)),
            ("estimated", (rmse_estimated, r2_estimated)),
        ):
            ours = [
                evidence.over(label, partial(agreed, what=f"{what}_speed", name=name, span=span))
                for span, name in _AGREEMENTS
            ]
            rows.append((f"case {int(label)}", what, *of_paper, *(mean.text(3) for mean in ours)))
    return Sheet(
        name="table-6",
        title="Table VI: agreement of measured and estimated speeds with the true ones.",
        columns=(
            "case",
            "speeds",
            "paper: RMSE, m/s",
            "paper: R²",
            "RMSE, m/s",
            "R²",
            "R², 10 to 60 s",
            "correlation², 10 to 60 s",
        ),
        rows=tuple(rows),
        note="Our values cover all vehicles: means over the seeds with their 95 % intervals."
        " R² = 1 - SS_res / SS_tot.",
    )


def _cases(evidence: Evidence, prefix: str, name: str, title: str) -> Sheet:
    rows: list[tuple[Cell, ...]] = []
    for model, pair in product(MODELS, PAIRS):
        label = prefix + case(model, pair)
        if label not in evidence.runs:
            continue
        cells = [evidence.over(label, merit).text(3) for merit in _MERITS.values()]
        rows.append((int(case(model, pair)), model, 100 * pair.error, pair.delay_s, *cells))
    seeds = len(next(iter(runs for label, runs in evidence.runs.items() if label == prefix + "15")))
    return Sheet(
        name=name,
        title=title,
        columns=("case", "model", "error, %", "delay, s", *_MERITS),
        rows=tuple(rows),
        note=f"Means over {seeds} seeds with their 95 % intervals.",
    )


def _fingerprints(evidence: Evidence) -> Sheet:
    rows = [
        (label, run.facts["seed"], run.facts["cycles"], run.facts["fingerprint"])
        for label, runs in evidence.runs.items()
        for run in runs
        if run.facts["fingerprint"]
    ]
    return Sheet(
        name="fingerprints",
        title="Fingerprint of every run that has one.",
        columns=("run", "seed", "cycles", "fingerprint"),
        rows=tuple(rows),
    )


def pictures(evidence: Evidence) -> tuple[Picture, ...]:
    """Return the figures of the paper's Section IV, and that of other gains."""
    found = [
        Picture(
            name="error-reduction",
            caption="Fig. k_1 to k_4. Left: the input of BCM, sensor readings with errors of up to"
            " 10 %. Right: the input of PBCM, the estimates of its filters. Both show the speed and"
            " the gap ahead of the vehicle that brakes, in the first minute, for the first seed.",
            draw=partial(figures.error_reduction, evidence),
        ),
        Picture(
            name="velocity-snapshots",
            caption="Speed of every vehicle at 9, 30, 100 and 300 s; error 10 %, delay 0.1 s, first"
            " seed.",
            draw=partial(figures.snapshots, evidence),
        ),
        Picture(
            name="heat-maps",
            caption="Speed of every vehicle over time; error 10 %, delay 0.1 s, first seed. Bright"
            " means fast; a uniform colour means stable. The bilateral models share a scale of 4"
            " m/s: on FM's scale of 60 m/s they would have a single colour.",
            draw=partial(figures.heat_maps, evidence),
        ),
        Picture(
            name="min-distance",
            caption="MinDistance over time for the four pairs of error and delay: mean over the"
            " seeds, with its 95 % interval as a band. Dotted: equal spacing.",
            draw=partial(figures.min_distances, evidence),
        ),
        Picture(
            name="min-distance-bars",
            caption="MinDistance with error bars: mean and standard deviation over the seeds and"
            " over 25 s each.",
            draw=partial(figures.min_distance_bars, evidence),
        ),
        Picture(
            name="max-distance",
            caption="MaxDistance over time, and with error bars; error 10 %, delay 0.1 s.",
            draw=partial(figures.max_distances, evidence),
        ),
    ]
    if gains.has_gains(evidence):
        found.append(gains.picture(evidence))
    return tuple(found)


def markdown(sheet: Sheet) -> str:
    """Return a sheet as a table in Markdown, with its title above and its note below."""
    shown = columns(sheet, len(sheet.rows))
    lines = [
        f"**{sheet.title}**",
        "",
        "| " + " | ".join(column.title for column in shown) + " |",
        "|" + "|".join("---:" if column.number else "---" for column in shown) + "|",
    ]
    lines += ["| " + " | ".join(row) + " |" for row in zip(*(c.cells for c in shown), strict=True)]
    return "\n".join([*lines, "", *([sheet.note, ""] if sheet.note else [])])


def claims_page(evidence: Evidence, how: Sequence[str]) -> str:
    """Return claims.md, with a row per claim; `how` says how the values were measured."""
    found = answers(evidence)
    counts = [f"{sum(a.verdict == v for _, a in found)} {v}" for v in _VERDICTS]
    lines = [
        "# The paper's claims, and what we measured",
        "",
        *how,
        "",
        f"Of {len(found)} claims: {', '.join(c for c in counts if not c.startswith('0 '))}.",
        "",
        "| where | the paper says | measured here | verdict | why |",
        "|---|---|---|---|---|",
        *(_claim_row(claim, answer) for claim, answer in found),
        "",
    ]
    return "\n".join(lines)


_VERDICTS: Final = (
    "confirmed",
    "stronger",
    "weaker",
    "not confirmed",
    "contradicts itself",
    "not tested",
)


def _claim_row(claim: Claim, answer: Answer) -> str:
    cells = (claim.where, claim.says, answer.ours, f"**{answer.verdict}**", answer.why)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
