"""The chapter on V2V: what the channel did to frames, and how old vehicles' data became."""

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
    """Return delivery, latency, age of information and bursts of losses; raises LogError."""
    if not run.frame_rows or not (outcomes := delivery(run.frames)).sent:
        reason = "No frame was in range of a receiver" if run.frame_rows else "No frame was logged"
        return Section(title=_TITLE, notes=(f"{reason}, so there is nothing to show.",))
    last_s = run.time_s[-1] if isinstance(run, Run) else run.scenario.duration_s
    notes = sentences(impairments(run.scenario, last_s), last_s)
    distances, latency = by_distance(run.frames), latencies(run.frames)
    sheets = [delivery_sheet(run, outcomes), distance_sheet(distances)]
    pictures = [_delivery_picture(distances, outcomes)]
    if len(run.busy_ratio):
        sheets.append(load_sheet(run))
        pictures.append(_load_picture(run))
    if latency is None:
        note = "Every frame was lost, so there is neither latency nor age of information."
        return Section(title=_TITLE, sheets=tuple(sheets), notes=(*notes, note))
    aged = ages(run.frames, run.vehicles, run.scenario.period_ns, run.scenario.v2v_wait_ns)
    sheets += [latency_sheet(run, latency), age_sheet(run, aged)]
    pictures.insert(0, _latency_picture(run, latency))
    if aged.cycles.max() > 0:
        pictures += _age_pictures(run, aged)
    else:
        notes.append("Every decision had the frames of its own cycle, so all ages are 0.")
    if outcomes.missed:
        bursts, loss_ratio = loss_bursts(run.frames, run.vehicles), outcomes.missed / outcomes.sent
        sheets.append(burst_sheet(bursts, loss_ratio))
        pictures.append(_burst_picture(bursts, loss_ratio))
    else:
        notes.append("No frame was lost, so there are no bursts of losses.")
    return Section(title=_TITLE, sheets=tuple(sheets), pictures=tuple(pictures), notes=tuple(notes))


def _latency_picture(run: Traffic, latency: Latencies) -> Picture:
    technology = run.scenario.channel.technology.name
    return Picture(
        name="v2v-latency",
        caption=(
            f"Latency of frames delivered over {technology}: histogram on the left, cumulative "
            "distribution on the right. Frames to the right of the dashed line are too late for "
            "the decision of their cycle."
        ),
        draw=lambda: draw_latency(latency, run.scenario.v2v_wait_ns * 1e-6, technology),
    )


def _delivery_picture(distances: Distances, outcomes: Delivery) -> Picture:
    return Picture(
        name="v2v-delivery",
        caption=(
            "Share of frames that reach a receiver in range, by its distance, with Wilson's 95 % "
            "interval. The dashed line is the share over all distances."
        ),
        draw=lambda: draw_delivery(distances, outcomes.delivered / outcomes.sent),
    )


def _load_picture(run: Traffic) -> Picture:
    return Picture(
        name="v2v-load",
        caption=(
            "Channel busy ratio: the share of each cycle in which a vehicle senses the frames of "
            "others or sends its own. The line is the mean over the vehicles, and the band reaches "
            "from the lowest to the highest."
        ),
        draw=lambda: draw_load(run.busy_ratio, run.scenario.period_ns * 1e-9, _marked(run)),
    )


def _marked(run: Traffic) -> list[Happening]:
    """Return what happened in a run; for drawn frames, what happens to the channel."""
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
                "other vehicle is at most this old (left) or older (right, on a logarithmic scale, "
                "where independent losses give a straight line). A vehicle ignores data that are "
                f"older than the limit of {limit_ms:g} ms."
            ),
            draw=lambda: draw_ages(counts, period_ms, limit_ms),
        ),
        Picture(
            name="v2v-age-map",
            caption=(
                "Mean age of information of every link. Grey links carried no frame. A bright row "
                "is a vehicle that receives badly; a bright column is a vehicle whose frames are "
                "received badly."
            ),
            draw=lambda: draw_age_map(aged, run.vehicles, period_ms),
        ),
    )


def _burst_picture(bursts: NDArray[np.int64], loss_ratio: float) -> Picture:
    return Picture(
        name="v2v-bursts",
        caption=(
            "Number of frames in a row that a link loses, and the geometric distribution that "
            "independent losses with the same ratio would have. If long bursts are more frequent "
            "than that, losses are correlated."
        ),
        draw=lambda: draw_bursts(bursts, loss_ratio),
    )
