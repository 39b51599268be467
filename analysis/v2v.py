"""The chapter on V2V: what the channel did to frames, and how old that left what vehicles know."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.ages import Ages, ages
from zenvoy.analysis.links import (
    Delivery,
    Distances,
    Latencies,
    by_distance,
    delivery,
    geometric,
    latencies,
    loss_bursts,
    wilson,
)
from zenvoy.analysis.load import Run
from zenvoy.analysis.section import Cell, Picture, Section, Sheet
from zenvoy.analysis.v2v_figures import (
    draw_age_map,
    draw_ages,
    draw_bursts,
    draw_delivery,
    draw_latency,
)

_TITLE: Final = "V2V"
_QUANTILES: Final = (0.5, 0.95, 0.99, 1.0)
_WILSON_NOTE: Final = (
    "The interval is Wilson's at 95 %, for losses that are independent of each other; where they "
    "come in bursts, it is too narrow."
)


def v2v_section(run: Run) -> Section:
    """Delivery, latency, age of information and bursts of losses; raises LogError."""
    if not run.frame_rows or not (told := delivery(run.frames)).sent:
        reason = "no frame was in range of a receiver" if run.frame_rows else "none was logged"
        return Section(title=_TITLE, notes=(f"There are no frames to look at: {reason}.",))
    distances, latency = by_distance(run.frames), latencies(run.frames)
    sheets = [delivery_sheet(run, told, latency), distance_sheet(distances)]
    pictures = [_delivery_picture(distances, told)]
    if latency is None:
        note = "Every frame was lost: there is neither latency nor age of information."
        return Section(title=_TITLE, sheets=tuple(sheets), notes=(note,))
    aged = ages(run.frames, run.vehicles, run.scenario.period_ns, run.scenario.v2v_wait_ns)
    sheets.append(age_sheet(run, aged))
    pictures.insert(0, _latency_picture(run, latency))
    notes = []
    if aged.cycles.max() > 0:
        pictures += _age_pictures(run, aged)
    else:
        notes.append("Every decision had the frames of its own cycle: no information aged.")
    if told.lost:
        bursts, loss_ratio = loss_bursts(run.frames, run.vehicles), told.lost / told.sent
        sheets.append(burst_sheet(bursts, loss_ratio))
        pictures.append(_burst_picture(bursts, loss_ratio))
    else:
        notes.append("No frame was lost: there are no bursts of losses.")
    return Section(title=_TITLE, sheets=tuple(sheets), pictures=tuple(pictures), notes=tuple(notes))


def delivery_sheet(run: Run, told: Delivery, latency: Latencies | None) -> Sheet:
    """One row: outcomes and latencies of the run."""
    low, high = wilson(np.array([told.delivered]), np.array([told.sent]))
    times: tuple[Cell, ...] = (None,) * (1 + len(_QUANTILES))
    if latency is not None:
        times = (latency.mean_ms, *(latency.quantile_ms(share) for share in _QUANTILES))
    return Sheet(
        name="v2v_delivery",
        title="Frames, one for each receiver in range",
        columns=(
            "technology",
            "sent",
            "delivered",
            "of them late",
            "lost",
            "delivered, %",
            "95 % from, %",
            "95 % to, %",
            "mean latency, ms",
            "median latency, ms",
            "95th percentile, ms",
            "99th percentile, ms",
            "longest latency, ms",
        ),
        rows=(
            (
                run.scenario.channel.technology,
                *told[:4],
                100.0 * told.delivered / told.sent,
                100.0 * float(low[0]),
                100.0 * float(high[0]),
                *times,
            ),
        ),
        note=f"A late frame missed the first delivery after it was sent. {_WILSON_NOTE}",
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
        name="v2v_distance",
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


def age_sheet(run: Run, aged: Ages) -> Sheet:
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
        name="v2v_age",
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
        name="v2v_bursts",
        title="Bursts of losses: frames of a link lost in a row",
        columns=("length", "bursts", "share, %", "share if independent, %"),
        rows=tuple(rows),
        note=(
            f"Mean length {mean:.3f}; losses that are independent, with the same ratio of "
            f"{100.0 * loss_ratio:.3g} %, have a mean length of "
            f"{1.0 / (1.0 - loss_ratio):.3f}."
        ),
    )


def link_groups(aged: Ages, run: Run) -> dict[str, NDArray[np.bool_]]:
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


def _latency_picture(run: Run, latency: Latencies) -> Picture:
    technology = run.scenario.channel.technology
    return Picture(
        name="v2v_latency",
        caption=(
            f"Latency of the frames that were delivered over {technology}: how it is spread, and "
            "the share of frames that took no longer. What is right of the dashed line is late "
            "for the decision of its cycle."
        ),
        draw=lambda: draw_latency(latency, run.scenario.control.v2v_wait_ms, technology),
    )


def _delivery_picture(distances: Distances, told: Delivery) -> Picture:
    return Picture(
        name="v2v_delivery",
        caption=(
            "Share of the frames that reach a receiver in range, by its distance, with Wilson's "
            "95 % interval. The dashed line is the share over all distances."
        ),
        draw=lambda: draw_delivery(distances, told.delivered / told.sent),
    )


def _age_pictures(run: Run, aged: Ages) -> tuple[Picture, Picture]:
    period_ms, limit_ms = run.scenario.period_ns * 1e-6, run.scenario.control.beacon_age_limit_ms
    counts: dict[str, NDArray[Any]] = {
        name: aged.of(links) for name, links in link_groups(aged, run).items()
    }
    return (
        Picture(
            name="v2v_age",
            caption=(
                "Age of information: the share of decisions for which the newest frame of the "
                "other vehicle is no older than this (left), and for which it is older (right, on "
                "a logarithmic scale: a straight line where losses are independent). Past the "
                f"limit of {limit_ms:g} ms a vehicle does without what the other told."
            ),
            draw=lambda: draw_ages(counts, period_ms, limit_ms),
        ),
        Picture(
            name="v2v_age_map",
            caption=(
                "Mean age of information of every link that carried a frame. Grey links never "
                "did. A bright row is a vehicle that hears badly, a bright column one that is "
                "badly heard."
            ),
            draw=lambda: draw_age_map(aged, run.vehicles, period_ms),
        ),
    )


def _burst_picture(bursts: NDArray[np.int64], loss_ratio: float) -> Picture:
    return Picture(
        name="v2v_bursts",
        caption=(
            "How many frames in a row a link loses, beside the geometric law that independent "
            "losses of the same ratio follow. Bars that reach above it for long bursts tell of a "
            "channel with a memory."
        ),
        draw=lambda: draw_bursts(bursts, loss_ratio),
    )
