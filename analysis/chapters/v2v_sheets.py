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
    "The interval is Wilson's at 95 %, for losses that are independent of each other; where they "
    "come in bursts, it is too narrow."
)


def delivery_sheet(run: Traffic, told: Delivery) -> Sheet:
    """One row: outcomes of the run."""
    low, high = wilson(np.array([told.delivered]), np.array([told.sent]))
    shares = (told.delivered / told.sent, float(low[0]), float(high[0]))
    technology = run.scenario.channel.technology.name
    return Sheet(
        name="v2v-delivery",
        title="Frames, one for each receiver in range",
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
        rows=((technology, *told, *(100.0 * share for share in shares)),),
        note=f"A late frame missed the first delivery after it was sent. {_WILSON_NOTE}",
    )


def load_sheet(run: Traffic) -> Sheet:
    """One row: how busy the medium was, over all vehicles and cycles; frames sent per second."""
    busy = 100.0 * run.busy_ratio
    quantiles = (float(np.quantile(busy, share)) for share in (0.5, 0.95, 1.0))
    frames = run.frames
    sent = len(np.unique(frames["source"].astype(np.int64) << 33 | frames["sequence"]))
    seconds = len(busy) * run.scenario.period_ns * 1e-9
    return Sheet(
        name="v2v-load",
        title="Load of the medium: channel busy ratio of vehicles and cycles",
        columns=(
            "mean, %",
            "median, %",
            "95th percentile, %",
            "highest, %",
            "frames sent per vehicle, 1/s",
        ),
        rows=((float(busy.mean()), *quantiles, sent / run.vehicles / seconds),),
        note="Share of a cycle in which a vehicle senses the frames of others or sends its own.",
    )


def latency_sheet(run: Traffic, latency: Latencies) -> Sheet:
    """One row: mean and quantiles of the latency of the frames that were delivered."""
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
    """Delivery by distance; bins in which nothing was sent are left out."""
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
    """Age of information on the links that controllers use, and on all."""
    period_ms = run.scenario.period_ns * 1e-6
    limit_ms = run.scenario.control.beacon_age_limit_ms
    rows: list[tuple[Cell, ...]] = []
    for name, links in link_groups(aged, run).items():
        counts, heard = aged.of(links), None
        number, total = np.arange(len(counts)), int(counts.sum())
        if total:
            reached = np.cumsum(counts) / total
            heard = (
                float((counts * number).sum()) / total * period_ms,
                *(float(np.searchsorted(reached, share)) * period_ms for share in (0.5, 0.95)),
                float(number[-1]) * period_ms,
                100.0 * float(counts[number * period_ms > limit_ms].sum()) / total,
            )
        rows.append((name, int(links.sum()), *(heard or (None,) * 5), aged.unheard(links)))
    return Sheet(
        name="v2v-age",
        title="Age of information when vehicles decide",
        columns=(
            "of what",
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
            "Time since the newest frame that has arrived by the instant of the decision was made; "
            f"past {limit_ms:g} ms data count as missing. Links that carried a frame at all."
        ),
    )


def burst_sheet(bursts: NDArray[np.int64], loss_ratio: float) -> Sheet:
    """Lengths of losses in a row, beside what independent losses would give."""
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
        title="Bursts of losses: frames of a link lost in a row",
        columns=("length", "bursts", "share, %", "share if independent, %"),
        rows=tuple(rows),
        note=(
            f"Mean length {mean:.3f}; losses that are independent, with the same ratio of "
            f"{100.0 * loss_ratio:.3g} %, have a mean length of "
            f"{1.0 / (1.0 - loss_ratio):.3f}."
        ),
    )


def link_groups(aged: Ages, run: Traffic) -> dict[str, NDArray[np.bool_]]:
    """Links by what the destination hears on them: the next vehicles, and everyone."""
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
