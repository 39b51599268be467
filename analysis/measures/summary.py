"""The summary of a run: what a user wants to know first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.arrays import read_frames
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.fallbacks import fallbacks
from zenvoy.analysis.measures.following import following
from zenvoy.analysis.measures.instants import PAPER_SPREAD_S, of_paper, row_at
from zenvoy.analysis.measures.links import arrived
from zenvoy.analysis.measures.metrics import Accuracy, accuracy, max_distance, min_distance
from zenvoy.analysis.measures.punctuality import missed_decisions, punctuality, quantiles
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.measures.spans import distances, disturbances, spans
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import HELD_UP
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]
Summary = dict[str, Any]


def summarize(path: Path) -> Summary:
    """Return the summary of the log at `path`, in the units of the field names; raises LogError.

    Figures that do not apply to the run are None, such as those of estimates where there are none.
    """
    return summary_of(load(path))


def summary_of(run: Run) -> Summary:
    """Return the summary of a run; raises LogError where its frames cannot be read.

    Its frames and its wall time are None where it was not logged.
    """
    summary = _result(run)
    if run.truth:
        summary |= _distances(run)
        summary |= following(run)
        summary |= _agreement(run)
    summary["collisions"] = sum(event.kind == pb.EVENT_COLLISION for event in run.events)
    summary["fallbacks"] = fallbacks(run.events, run.scenario)
    summary["frames"] = None if run.path is None else _frames(run.path)
    if HELD_UP in run.result:
        summary["held_up"] = run.result[HELD_UP]
    if run.scenario.clock == "realtime":
        summary["real_time"] = _real_time(run)
    return summary


def _result(run: Run) -> Summary:
    """Return how the run ended; from the last row of /clock where the log has no result."""
    result = run.result
    last = {name: column[-1] for name, column in run.clock.items()}
    cycles, time_ns, wall_ns = (int(last.get(name, 0)) for name in ("cycle", "time_ns", "wall_ns"))
    real_time_factor = float(last.get("real_time_factor", 0.0))
    timed = run.path is not None
    return {
        "scenario": run.name,
        "seed": run.seed,
        "bus": run.run["bus"],
        "notes": list(run.notes),
        "holds": all(check.holds is not False for check in run.checks),
        "end": result.get("end"),
        "fingerprint": run.fingerprint,
        "cycles": int(result.get("cycles", cycles)),
        "simulated_s": float(result.get("simulated_s", time_ns * 1e-9)),
        "wall_s": float(result.get("wall_s", wall_ns * 1e-9)) if timed else None,
        "real_time_factor": float(result.get("real_time_factor", real_time_factor))
        if timed
        else None,
    }


def _distances(run: Run) -> Summary:
    """Return gaps and speeds at the instants that the paper examines."""
    truth, time_s = run.truth, run.time_s
    gap = gaps(truth["position"], run.scenario.ring_length_m)
    smallest, largest = min_distance(gap), max_distance(gap)
    row = row_at(time_s, PAPER_SPREAD_S)
    spread = float(truth["speed"][row].std()) if of_paper(run) and row < len(time_s) else None
    smallest_m, spacing = float(np.nanmin(gap)), spacing_of(run.scenario)
    return {
        "smallest_gap_m": smallest_m,
        "smallest_bumper_gap_m": spacing.shown(smallest_m) if spacing.less_m else None,
        "distance_m": {
            span.name: _span(distances(span, time_s, smallest, largest))
            for span in sorted(spans(disturbances(run.events), time_s[-1]))
        },
        "speed_spread_at_100_s_mps": spread,
    }


def _span(value: tuple[float, float] | None) -> Summary | None:
    return None if value is None else {"min": value[0], "max": value[1]}


def _agreement(run: Run) -> Summary:
    """Compare measured and estimated own speed and gap ahead with the truth."""
    cycles, radar, estimate = run.cycles, run.radar, run.estimate
    if not cycles:
        return {"speed": None, "gap": None}
    speed = run.truth["speed"][:cycles]
    gap = gaps(run.truth["position"][:cycles], run.scenario.ring_length_m)
    return {
        "speed": {
            "measured": _values(accuracy(radar["speed"][:cycles], speed)),
            "estimated": _values(accuracy(estimate["speed"][:cycles], speed)),
        },
        "gap": {
            "measured": _values(accuracy(radar["gap"][:cycles], gap)),
            "estimated": _values(accuracy(estimate["ahead_gap"][:cycles], gap)),
        },
    }


def _real_time(run: Run) -> Summary | None:
    """Return how punctual the run was; None where no cycle was logged."""
    found = punctuality(run)
    if found is None:
        return None
    missed, due = missed_decisions(run)
    kinds = ("cycle", "sense", "decision", "command", "delivery")
    lateness = {kind: quantiles(getattr(found, kind)) for kind in kinds}
    error = quantiles(found.clock_error)
    drift = found.clock_drift
    return {
        "speed": run.scenario.speed,
        "clock_error_ms": None if error is None else error._asdict(),
        "clock_drift_ppm": None if drift is None else list(drift),
        "lateness_ms": {
            kind: None if values is None else values._asdict() for kind, values in lateness.items()
        },
        "commands_late": found.commands_late,
        "commands_missing": found.commands_missing,
        "frames_due": due,
        "frames_that_missed_their_decision": missed,
        "overruns": found.overruns,
        "drift_ms": found.drift_ms,
    }


def _values(value: Accuracy | None) -> Summary | None:
    return None if value is None else value._asdict()


def _frames(path: Path) -> Summary:
    """Count frames by outcome; a frame counts once for each receiver in range."""
    counts = np.zeros(max(pb.Outcome.values()) + 1, dtype=np.int64)
    latencies = [np.zeros(0, dtype=np.int64)]
    for table in read_frames(path):
        counts += np.bincount(table["outcome"], minlength=len(counts))
        latencies.append(table["latency_ns"][arrived(table)])
    latency_ms = np.concatenate(latencies) * 1e-6
    lost, late = int(counts[pb.OUTCOME_LOST]), int(counts[pb.OUTCOME_LATE])
    delivered, corrupted = (
        int(counts[pb.OUTCOME_DELIVERED]) + late,
        int(counts[pb.OUTCOME_CORRUPTED]),
    )
    collided = int(counts[pb.OUTCOME_COLLIDED])
    return {
        "sent": delivered + lost + corrupted + collided,
        "delivered": delivered,
        "late": late,
        "lost": lost,
        "corrupted": corrupted,
        "collided": collided,
        "second_copies": int(counts[pb.OUTCOME_DUPLICATE]),
        "latency_mean_ms": float(latency_ms.mean()) if latency_ms.size else None,
        "latency_p95_ms": float(np.percentile(latency_ms, 95)) if latency_ms.size else None,
    }
