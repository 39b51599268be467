"""The digest of a run, which a study keeps after deleting the log: some hundred kilobytes."""

from __future__ import annotations

import json
import math
import os
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.agreement import agreement
from zenvoy.analysis.measures.fallbacks import fallbacks
from zenvoy.analysis.measures.instants import PAPER_S, row_at
from zenvoy.analysis.measures.metrics import max_distance, min_distance
from zenvoy.analysis.measures.quantities import first_disturbed
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import versions_of
from zenvoy.bus.topics import ESTIMATE, RADAR, TRUTH
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]

COLUMNS: Final = {
    TRUTH.log_name: ("position", "speed"),
    RADAR.log_name: ("gap", "speed"),
    ESTIMATE.log_name: ("ahead_gap", "speed"),
}
"""The columns of a run that a digest is made of, by topic."""

_STANDS_MPS: Final = 0.1
# Agreement with the truth is computed over the whole run, and while the braking has an effect.
_SPANS_S: Final = {"whole": (0.0, math.inf), "disturbed": (10.0, 60.0)}
_ARRAYS: Final = (
    "time_s",
    "min_distance",
    "max_distance",
    "spread",
    "mean_speed",
    "snapshots",
    "speed",
    "link",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Digest:
    """The digest of one run with T rows of truth and n vehicles.

    time_s, min_distance and max_distance (m), spread (standard deviation of speed over the
    vehicles, m/s) and mean_speed (m/s) are (T,). snapshots holds the speeds at PAPER_S (m/s),
    (4, n), NaN after the run's end. speed holds every tenth row of speeds (m/s), (T // 10 + 1, n).
    link holds true, measured and estimated speed (m/s) of the `first_disturbed` vehicle, then the
    same for its gap (m), (6, cycles). facts holds single numbers and names.
    """

    time_s: Floats
    min_distance: Floats
    max_distance: Floats
    spread: Floats
    mean_speed: Floats
    snapshots: Floats
    speed: NDArray[np.float32]
    link: NDArray[np.float32]
    facts: dict[str, Any]

    def save(self, path: Path) -> None:
        """Write the digest whole or not at all."""
        partial = path.with_name(path.name + ".partial")
        with partial.open("wb") as file:
            arrays = {name: getattr(self, name) for name in _ARRAYS}
            np.savez_compressed(file, facts=np.array(json.dumps(self.facts)), **arrays)
        os.replace(partial, path)

    @classmethod
    def read(cls, path: Path) -> Digest:
        """Return the digest saved at `path`; raises OSError, ValueError or KeyError."""
        try:
            with path.open("rb") as file, np.load(file) as stored:
                arrays = {name: stored[name] for name in _ARRAYS}
                return cls(facts=json.loads(str(stored["facts"])), **arrays)
        except (zipfile.BadZipFile, zlib.error, EOFError) as error:
            raise ValueError(f"{path}: damaged: {error}") from error


def digest(run: Run) -> Digest:
    """Return the digest of `run`, whose log has at least two cycles."""
    truth, time_s = run.truth, run.time_s
    gap = gaps(truth["position"], run.scenario.ring_length_m)
    speed = truth["speed"]
    snapshots = np.full((len(PAPER_S), run.vehicles), np.nan)
    for row, at_s in enumerate(PAPER_S):
        index = row_at(time_s, at_s)
        if index < len(time_s):
            snapshots[row] = speed[index]
    return Digest(
        time_s=time_s,
        min_distance=min_distance(gap),
        max_distance=max_distance(gap),
        spread=speed.std(axis=1),
        mean_speed=speed.mean(axis=1),
        snapshots=snapshots,
        speed=speed[::10].astype(np.float32),
        link=_link(run, gap),
        facts=_facts(run, gap),
    )


def _link(run: Run, gap: Floats) -> NDArray[np.float32]:
    rows, column = run.cycles, first_disturbed(run) - 1
    columns = (
        run.truth["speed"],
        run.radar["speed"],
        run.estimate["speed"],
        gap,
        run.radar["gap"],
        run.estimate["ahead_gap"],
    )
    return np.array([values[:rows, column] for values in columns], dtype=np.float32)


def _facts(run: Run, gap: Floats) -> dict[str, Any]:
    speed = run.truth["speed"]
    kinds = [event.kind for event in run.events]
    return {
        "scenario": run.name,
        "seed": run.seed,
        "vehicle": first_disturbed(run),
        "fingerprint": run.fingerprint or "",
        "end": run.result.get("end", ""),
        "cycles": len(speed) - 1,
        "wall_s": float(run.result.get("wall_s", "nan")),
        "version": versions_of(run.run).get("zenvoy", "unknown"),
        "smallest_gap_m": float(np.nanmin(gap)),
        "collisions": kinds.count(pb.EVENT_COLLISION),
        "fallbacks": fallbacks(run.events, run.scenario),
        "standing": {
            f"{at_s:g}": int(np.count_nonzero(speed[row] < _STANDS_MPS))
            for at_s in PAPER_S
            if (row := row_at(run.time_s, at_s)) < len(speed)
        },
        "fit": {name: _agreements(run, gap, span) for name, span in _SPANS_S.items()},
    }


def _agreements(
    run: Run, gap: Floats, span_s: tuple[float, float]
) -> dict[str, dict[str, float] | None]:
    """Compare readings and estimates of all vehicles with the truth over a span of time."""
    time_s = run.time_s[: run.cycles]
    rows = np.flatnonzero((time_s >= span_s[0]) & (time_s < span_s[1]))
    pairs = {
        "measured_speed": (run.radar["speed"], run.truth["speed"]),
        "estimated_speed": (run.estimate["speed"], run.truth["speed"]),
        "measured_gap": (run.radar["gap"], gap),
        "estimated_gap": (run.estimate["ahead_gap"], gap),
    }
    return {name: _agreement(values[rows], truth[rows]) for name, (values, truth) in pairs.items()}


def _agreement(values: Floats, truth: Floats) -> dict[str, float] | None:
    found = agreement(values, truth)
    if found is None:
        return None
    return {"rmse": found.rmse, "r2": found.r2, "r2_correlation": found.r2_correlation}
