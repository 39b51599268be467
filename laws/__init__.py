"""The control laws of vehicles: the record of a law, and the laws that come with Zenvoy."""

from __future__ import annotations

from zenvoy.laws.arithmetic import clipped, known, larger, power, root, share, smaller, where
from zenvoy.laws.estimator import Estimator, LinearModel, Tracker
from zenvoy.laws.law import (
    Column,
    Law,
    Linear,
    Needs,
    NoParameters,
    Observation,
    Output,
    Setpoint,
)
from zenvoy.laws.relative import Motion, Number, Relative
from zenvoy.laws.table import builtin, find, law_of, parameters_from, register

__all__ = [
    "Column",
    "Estimator",
    "Law",
    "Linear",
    "LinearModel",
    "Motion",
    "Needs",
    "NoParameters",
    "Number",
    "Observation",
    "Output",
    "Relative",
    "Setpoint",
    "Tracker",
    "builtin",
    "clipped",
    "find",
    "known",
    "larger",
    "law_of",
    "parameters_from",
    "power",
    "register",
    "root",
    "share",
    "smaller",
    "where",
]
