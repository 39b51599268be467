"""A small study of two axes, and one of its runs as a scenario."""

from __future__ import annotations

from typing import Final

STUDY: Final = """
scenario: quickstart
description: Frames lost, against the gain of relative speed.
settings:
  fleet: {size: 6}
  events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3}]
duration_s: 3
axes:
  channel.loss.p: [0, 0.9]
  control.gains.k_v: {from: 0.3, to: 0.6, steps: 2}
seeds: [1, 4]
measures: [smallest_gap_m, speed.estimated.rmse, fallbacks, frames.lost, speed_spread_at_100_s_mps]
series: [mean_speed_mps]
"""
SCENARIO: Final = """
extends: quickstart
fleet: {size: 6}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3}]
duration_s: 3
channel: {loss: {p: 0.9}}
control: {gains: {k_v: 0.3}}
seed: 4
"""
