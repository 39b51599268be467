"""Tables of the chapter on V2V."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.ages import Ages
from zenvoy.analysis.measures.links import Delivery, Distances, Latencies, geometric, wilson
from zenvoy.analysis.measures.traffic import Traffic
from zenvoy.analysis.page.section import Cell, Sheet

_WILSON_NOTE: Final = (
    "The interval is Wilson's at 95 %, for independent losses. It is too narrow if losses come in "
    "bursts."
)


def delivery_sheet(run: Traffic, outcomes: Delivery) -> Sheet:
    """Return one row with the outcomes of the run's frames."""
    low, high = wilson(np.array([outcomes.delivered]), np.array([outcomes.sent]))
    shares = (outcomes.delivered / outcomes.sent, float(low[0]), float(high[0]))
    technology = run.scenario.channel.technology.name
    return Sheet(
        name="v2v-delivery",
        title="Outcomes of frames, for each receiver in range",
        columns=(
            "technology",
            "sent",
            "delivered",
            "of them late",
            "lost",
            "damaged",
            "second copies",
            "collided",
            "delivered, %",
            "95 % from, %",
            "95 % to, %",
        ),
        rows=((technology, *outcomes, *(100.0 * share for share in shares)),),
        note=f"A late frame missed the first delivery after it was sent. {_WILSON_NOTE}",
    )


def load_sheet(run: Traffic) -> Sheet:
    """Return one row with the channel busy ratio over all vehicles and cycles, and the rate."""
    busy = 100.0 * run.busy_ratio
    quantiles = (float(np.quantile(busy, share)) for share in (0.5, 0.95, 1.0))
    frames = run.frames
    sent = len(np.unique(frames["source"].astype(np.int64) << 33 | frames["sequence"]))
    seconds = len(busy) * run.scenario.period_ns * 1e-9
    return Sheet(
        name="v2v-load",
        title="Load of the medium: channel busy ratio over vehicles and cycles",
        columns=(
            "mean, %",
            "median, %",
            "95th percentile, %",
            "highest, %",
            "frames sent per vehicle, 1/s",
        ),
        rows=((float(busy.mean()), *quantiles, sent / run.vehicles / seconds),),
        note="The channel busy ratio is the share of a cycle in which a vehicle senses the frames "
        "of others or sends its own.",
    )


def latency_sheet(run: Traffic, latency: Latencies) -> Sheet:
    """Return one row with mean and quantiles of the latency of delivered frames."""
    quantiles = (latency.quantile_ms(share) for share in (0.5, 0.95, 0.99, 1.0))
    return Sheet(
        name="v2v-latency",
        title="Latency of delivered frames",
        columns=(
            "technology",
            "mean, ms",
            "median, ms",
            "95th percentile, ms",
            "99th percentile, ms",
            "longest, ms",
        ),
        rows=((run.scenario.channel.technology.name, latency.mean_ms, *quantiles),),
    )


def distance_sheet(found: Distances) -> Sheet:
    """Return delivery by distance; bins in which nothing was sent are left out."""
    low, high = wilson(found.delivered, found.sent)
    rows = [
        (
            float(found.edges_m[at]),
            float(found.edges_m[at + 1]),
            int(sent),
            int(found.delivered[at]),
            100.0 * float(found.delivered[at]) / float(sent),
            100.0 * float(low[at]),
            100.0 * float(high[at]),
        )
        for at, sent in enumerate(found.sent)
        if sent
    ]
    return Sheet(
        name="v2v-distance",
        title="Delivery by distance",
        columns=(
            "from, m",
            "to, m",
            "sent",
            "delivered",
            "delivered, %",
            "95 % from, %",
            "95 % to, %",
        ),
        rows=tuple(rows),
        note=_WILSON_NOTE,
    )


def age_sheet(run: Traffic, aged: Ages) -> Sheet:
    """Return the age of information on the links that controllers use, and on all links."""
    period_ms = run.scenario.period_ns * 1e-6
    limit_ms = run.scenario.control.beacon_age_limit_ms
    rows: list[tuple[Cell, ...]] = []
    for name, links in link_groups(aged, run).items():
        counts, ages_ms = aged.of(links), None
        number, total = np.arange(len(counts)), int(counts.sum())
        if total:
            reached = np.cumsum(counts) / total
            ages_ms = (
                float((counts * number).sum()) / total * period_ms,
                *(float(np.searchsorted(reached, share)) * period_ms for share in (0.5, 0.95)),
                float(number[-1]) * period_ms,
                100.0 * float(counts[number * period_ms > limit_ms].sum()) / total,
            )
        rows.append((name, int(links.sum()), *(ages_ms or (None,) * 5), aged.before_first(links)))
    return Sheet(
        name="v2v-age",
        title="Age of information when vehicles decide",
        columns=(
            "data of",
            "links",
            "mean, ms",
            "median, ms",
            "95th percentile, ms",
            "oldest, ms",
            f"older than {limit_ms:g} ms, %",
            "cycles before the first frame",
        ),
        rows=tuple(rows),
        note=(
            "The age is the time since the newest frame that arrived before the decision was made. "
            f"Data older than {limit_ms:g} ms count as missing. Only links that carried a frame "
            "are counted."
        ),
    )


def burst_sheet(bursts: NDArray[np.int64], loss_ratio: float) -> Sheet:
    """Return the lengths of bursts of losses, with those of independent losses."""
    total = int(bursts.sum())
    expected = geometric(loss_ratio, len(bursts) - 1)
    rows: list[tuple[Cell, ...]] = [
        (length, int(number), 100.0 * int(number) / total, 100.0 * float(expected[length]))
        for length, number in enumerate(bursts)
        if length
    ]
    mean = float((bursts * np.arange(len(bursts))).sum()) / total
    return Sheet(
        name="v2v-bursts",
        title="Bursts of losses: consecutive losses on a link",
        columns=("length", "bursts", "share, %", "share if independent, %"),
        rows=tuple(rows),
        note=(
            f"The mean length is {mean:.3f}. Independent losses with the same ratio of "
            f"{100.0 * loss_ratio:.3g} % would have a mean length of "
            f"{1.0 / (1.0 - loss_ratio):.3f}."
        ),
    )


def link_groups(aged: Ages, run: Traffic) -> dict[str, NDArray[np.bool_]]:
    """Group links by the position of the sender: vehicle ahead, vehicle behind, all."""
    n, ring = run.vehicles, run.scenario.ring_length_m is not None
    ahead = aged.source == aged.destination - 1
    behind = aged.source == aged.destination + 1
    if ring:
        ahead |= (aged.source == n) & (aged.destination == 1)
        behind |= (aged.source == 1) & (aged.destination == n)
    return {
        "vehicle ahead": ahead,
        "vehicle behind": behind,
        "all in range": np.ones(len(aged.source), dtype=np.bool_),
    }
