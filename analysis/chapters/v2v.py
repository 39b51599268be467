"""The chapter on V2V: what the channel did to frames, and how old that left what vehicles know."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.chapters.v2v_pictures import (
    draw_age_map,
    draw_ages,
    draw_bursts,
    draw_delivery,
    draw_latency,
    draw_load,
)
from zenvoy.analysis.chapters.v2v_sheets import (
    age_sheet,
    burst_sheet,
    delivery_sheet,
    distance_sheet,
    latency_sheet,
    link_groups,
    load_sheet,
)
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.ages import Ages, ages
from zenvoy.analysis.measures.links import (
    Delivery,
    Distances,
    Latencies,
    by_distance,
    delivery,
    latencies,
    loss_bursts,
)
from zenvoy.analysis.measures.traffic import Traffic
from zenvoy.analysis.page.happenings import Happening, happenings, impairments, sentences
from zenvoy.analysis.page.section import Picture, Section

_TITLE: Final = "V2V"


def v2v_section(run: Traffic) -> Section:
    """Delivery, latency, age of information and bursts of losses; raises LogError."""
    if not run.frame_rows or not (told := delivery(run.frames)).sent:
        reason = "no frame was in range of a receiver" if run.frame_rows else "none was logged"
        return Section(title=_TITLE, notes=(f"There are no frames to look at: {reason}.",))
    last_s = run.time_s[-1] if isinstance(run, Run) else run.scenario.duration_s
    notes = sentences(impairments(run.scenario, last_s), last_s)
    distances, latency = by_distance(run.frames), latencies(run.frames)
    sheets = [delivery_sheet(run, told), distance_sheet(distances)]
    pictures = [_delivery_picture(distances, told)]
    if len(run.busy_ratio):
        sheets.append(load_sheet(run))
        pictures.append(_load_picture(run))
    if latency is None:
        note = "Every frame was lost: there is neither latency nor age of information."
        return Section(title=_TITLE, sheets=tuple(sheets), notes=(*notes, note))
    aged = ages(run.frames, run.vehicles, run.scenario.period_ns, run.scenario.v2v_wait_ns)
    sheets += [latency_sheet(run, latency), age_sheet(run, aged)]
    pictures.insert(0, _latency_picture(run, latency))
    if aged.cycles.max() > 0:
        pictures += _age_pictures(run, aged)
    else:
        notes.append("Every decision had the frames of its own cycle: no information aged.")
    if told.missed:
        bursts, loss_ratio = loss_bursts(run.frames, run.vehicles), told.missed / told.sent
        sheets.append(burst_sheet(bursts, loss_ratio))
        pictures.append(_burst_picture(bursts, loss_ratio))
    else:
        notes.append("No frame was lost: there are no bursts of losses.")
    return Section(title=_TITLE, sheets=tuple(sheets), pictures=tuple(pictures), notes=tuple(notes))


def _latency_picture(run: Traffic, latency: Latencies) -> Picture:
    technology = run.scenario.channel.technology.name
    return Picture(
        name="v2v-latency",
        caption=(
            f"Latency of the frames that were delivered over {technology}: how it is spread, and "
            "the share of frames that took no longer. What is right of the dashed line is late "
            "for the decision of its cycle."
        ),
        draw=lambda: draw_latency(latency, run.scenario.v2v_wait_ns * 1e-6, technology),
    )


def _delivery_picture(distances: Distances, told: Delivery) -> Picture:
    return Picture(
        name="v2v-delivery",
        caption=(
            "Share of the frames that reach a receiver in range, by its distance, with Wilson's "
            "95 % interval. The dashed line is the share over all distances."
        ),
        draw=lambda: draw_delivery(distances, told.delivered / told.sent),
    )


def _load_picture(run: Traffic) -> Picture:
    return Picture(
        name="v2v-load",
        caption=(
            "Channel busy ratio: the share of each cycle in which a vehicle senses the frames of "
            "others or sends its own, as the mean over the vehicles and from the idlest to the "
            "busiest."
        ),
        draw=lambda: draw_load(run.busy_ratio, run.scenario.period_ns * 1e-9, _marked(run)),
    )


def _marked(run: Traffic) -> list[Happening]:
    """What happened; of frames that no run has logged, what happens to the channel."""
    if isinstance(run, Run):
        return happenings(run)
    return impairments(run.scenario, run.scenario.duration_s)


def _age_pictures(run: Traffic, aged: Ages) -> tuple[Picture, Picture]:
    period_ms, limit_ms = run.scenario.period_ns * 1e-6, run.scenario.control.beacon_age_limit_ms
    counts: dict[str, NDArray[Any]] = {
        name: aged.of(links) for name, links in link_groups(aged, run).items()
    }
    return (
        Picture(
            name="v2v-age",
            caption=(
                "Age of information: the share of decisions for which the newest frame of the "
                "other vehicle is no older than this (left), and for which it is older (right, on "
                "a logarithmic scale: a straight line where losses are independent). Past the "
                f"limit of {limit_ms:g} ms a vehicle does without what the other told."
            ),
            draw=lambda: draw_ages(counts, period_ms, limit_ms),
        ),
        Picture(
            name="v2v-age-map",
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
        name="v2v-bursts",
        caption=(
            "How many frames in a row a link loses, beside the geometric law that independent "
            "losses of the same ratio follow. Bars that reach above it for long bursts tell of a "
            "channel with a memory."
        ),
        draw=lambda: draw_bursts(bursts, loss_ratio),
    )
