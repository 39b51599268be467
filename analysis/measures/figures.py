"""The figures of a summary under dotted names, each with its unit and meaning."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final


@dataclass(frozen=True, slots=True)
class Measure:
    """What a figure is: its unit ("" for counts and ratios), and its meaning in words."""

    unit: str
    meaning: str
    needs_log: bool = False
    """Whether only a run that was logged has it: counts of frames, and wall time."""


_SPANS: Final = {
    "before_braking": "before the first braking",
    "before_disturbance": "before the first disturbance",
    "dip": "from the first disturbance to 30 s after the last, extreme",
    "end": "in the last 5 s",
}
_FRAMES: Final = {
    "sent": "frames sent, once for each receiver in range",
    "delivered": "frames delivered",
    "late": "frames delivered after the decision of their cycle",
    "lost": "frames lost",
    "corrupted": "frames corrupted",
    "collided": "frames collided on the medium",
    "second_copies": "second copies delivered",
}


def _measures() -> Iterator[tuple[str, Measure]]:
    yield "smallest_gap_m", Measure("m", "smallest gap of the run")
    yield "smallest_bumper_gap_m", Measure("m", "smallest gap of the run, bumper to bumper")
    for span, words in _SPANS.items():
        yield f"distance_m.{span}.min", Measure("m", f"MinDistance {words}")
        yield f"distance_m.{span}.max", Measure("m", f"MaxDistance {words}")
    yield "speed_spread_at_100_s_mps", Measure("m/s", "spread of speed at 100 s")
    yield "gap_error_rms_m", Measure("m", "RMS error of the gaps from their mean")
    yield "tail_speed_swing_mps", Measure("m/s", "swing of speed of the tail")
    yield "speed_swing_ratio", Measure("", "swing of speed, tail over head")
    yield "acceleration_rms_mps2", Measure("m/s²", "RMS acceleration")
    yield "jerk_rms_mps3", Measure("m/s³", "RMS jerk")
    for quantity, unit in (("speed", "m/s"), ("gap", "m")):
        for kind in ("measured", "estimated"):
            name, what = f"{quantity}.{kind}", f"{kind} {quantity}"
            yield f"{name}.rmse", Measure(unit, f"RMSE of the {what}")
            yield f"{name}.r2", Measure("", f"R² of the {what}")
            yield f"{name}.spread", Measure(unit, f"spread of the true {quantity} ({kind})")
    yield "collisions", Measure("", "collisions")
    yield "fallbacks", Measure("", "fallbacks to FM")
    for name, words in _FRAMES.items():
        yield f"frames.{name}", Measure("", words, needs_log=True)
    yield (
        "frames.latency_mean_ms",
        Measure("ms", "mean latency of delivered frames", needs_log=True),
    )
    yield "frames.latency_p95_ms", Measure("ms", "95th percentile of latency", needs_log=True)
    yield "cycles", Measure("", "cycles of the run")
    yield "simulated_s", Measure("s", "simulated time")
    yield "wall_s", Measure("s", "wall time of the run", needs_log=True)
    yield "real_time_factor", Measure("", "simulated time per wall time", needs_log=True)


MEASURES: Final[Mapping[str, Measure]] = MappingProxyType(dict(_measures()))
"""Every figure that the summary of a run in lock-step can have."""


def figures(summary: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the figures of a summary by their names in MEASURES.

    A figure that does not apply to the run, or is NaN, is None.
    """
    return {name: _number(summary, name) for name in MEASURES}


def _number(summary: Mapping[str, Any], name: str) -> float | None:
    value: Any = summary
    for step in name.split("."):
        value = value.get(step) if isinstance(value, Mapping) else None
    return value if isinstance(value, int | float) and math.isfinite(value) else None
