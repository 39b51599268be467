"""PI with saturation: drives at the mean of its own recent speeds, which a wave hardly changes.

Stern et al. (2018), "Dissipation of stop-and-go waves via control of autonomous vehicles: Field
experiments", section 3.2. In the field the speed went to the car's own controller of speed, which
the paper does not give; here the vehicle approaches it with a time constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from zenvoy.laws.arithmetic import larger, share, smaller, where
from zenvoy.laws.law import Law, Observation, Output
from zenvoy.laws.parameters import NonNegative, Positive
from zenvoy.laws.relative import Number

_SPANS: Final = 38  # of which the window of the mean speed is made
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Parameters:
    """The constants of the experiment.

    window_s is the time over which the own speed is averaged, about one lap. catch_up_mps is the
    most by which the target exceeds that mean; it is reached between lower_gap_m and upper_gap_m.
    The gap is safe from the larger of safe_gap_m and safe_time_s times the relative speed on, and
    the target counts fully transition_m (γ) above. tracking_s is the time constant with which the
    vehicle takes on the commanded speed.
    """

    window_s: Positive = 38.0
    catch_up_mps: NonNegative = 1.0
    lower_gap_m: NonNegative = 7.0
    upper_gap_m: Positive = 30.0
    safe_time_s: NonNegative = 2.0
    safe_gap_m: NonNegative = 4.0
    transition_m: Positive = 2.0
    tracking_s: Positive = 0.5

    def __post_init__(self) -> None:
        if not self.lower_gap_m < self.upper_gap_m:
            raise ValueError("lower_gap_m must be less than upper_gap_m")


class Memory(NamedTuple):
    """The state of the law: the last command (m/s), and the mean speeds of recent spans (m/s).

    A span is 1/38 of the window, rounded up to whole periods. `decisions` counts those of the
    present span, and `total` adds up its speeds. `known` is the number of spans before it in
    `means`, the newest first.
    """

    command: Number
    decisions: Number
    total: Number
    known: Number
    means: tuple[Number, ...]


_NEW: Final = (0.0,) * (4 + _SPANS)


def saturated(seen: Observation, own: Parameters) -> Output:
    """Return the acceleration of the host, m/s², and what it remembers (Eqs. 3 to 5)."""
    command, decisions, total, known, *means = seen.state
    memory = Memory(command, decisions, total, known, tuple(means))
    starts = memory.known + memory.decisions < 0.5
    memory = memory._replace(
        command=where(starts, seen.speed, memory.command),
        decisions=memory.decisions + 1.0,
        total=memory.total + seen.speed,
    )
    leader = seen.speed + seen.ahead.v
    gap = seen.ahead.p - seen.length_m
    safe_m = larger(own.safe_time_s * seen.ahead.v, own.safe_gap_m)
    target = _mean_speed(memory, seen.period_s, own)
    target = target + own.catch_up_mps * share(gap, own.lower_gap_m, own.upper_gap_m)
    alpha = share(gap, safe_m, safe_m + own.transition_m)
    beta = 1.0 - 0.5 * alpha
    wanted = alpha * target + (1.0 - alpha) * leader
    command = beta * wanted + (1.0 - beta) * memory.command
    memory = _moved_on(memory._replace(command=command), seen.period_s, own)
    return Output((command - seen.speed) / own.tracking_s, state=(*memory[:4], *memory.means))


def _mean_speed(memory: Memory, period_s: float, own: Parameters) -> Number:
    """Return the mean of the own speed over the window, or over the time since the start, m/s.

    The oldest span counts as far as it lies within the window.
    """
    span_s = _decisions_in_a_span(period_s, own) * period_s
    time_s = memory.decisions * period_s
    left_s, way_m = own.window_s - time_s, memory.total * period_s
    for number, mean in enumerate(memory.means):
        weight_s = smaller(span_s, larger(0.0, left_s - number * span_s))
        weight_s = where(memory.known > number + 0.5, weight_s, 0.0)
        time_s, way_m = time_s + weight_s, way_m + weight_s * mean
    return way_m / time_s


def _moved_on(memory: Memory, period_s: float, own: Parameters) -> Memory:
    """Return the memory with the present span among the others, if it is over."""
    over = memory.decisions > _decisions_in_a_span(period_s, own) - 0.5
    shifted = (memory.total / memory.decisions, *memory.means[:-1])
    return Memory(
        command=memory.command,
        decisions=where(over, 0.0, memory.decisions),
        total=where(over, 0.0, memory.total),
        known=where(over, smaller(1.0 * _SPANS, memory.known + 1.0), memory.known),
        means=tuple(where(over, new, old) for new, old in zip(shifted, memory.means, strict=True)),
    )


def _decisions_in_a_span(period_s: float, own: Parameters) -> int:
    return max(1, math.ceil(own.window_s / (_SPANS * period_s) - _ROUNDING))


LAW = Law(
    name="PI",
    acceleration=saturated,
    parameters=Parameters,
    keeps_gap=False,
    state=_NEW,
    mode=11,
    colour="#999933",
)
