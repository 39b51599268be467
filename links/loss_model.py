"""The record of a loss model: its place in a scenario, its checks and its maths."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws, Seeds, numbered
from zenvoy.links.sent_frames import Scene, SentFrames

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_FIRST_OWN: Final = 64  # below are the numbers that are written down, in records and in `Purpose`
_NUMBERS: Final = 256


class Effect(Enum):
    """What a model says of each frame.

    LOSS_CHANCE: the probability that it is lost. One draw per frame serves all such models, so a
    model that loses fewer frames loses a part of those that another one loses. DAMAGE_CHANCE: the
    probability that it arrives damaged, likewise. LOSS: whether it is lost, by the model's draws.
    """

    LOSS_CHANCE = "loss chance"
    DAMAGE_CHANCE = "damage chance"
    LOSS = "loss"


class Disagreement(NamedTuple):
    """Values that are fine alone and impossible together: at which key, why, with which others."""

    key: str
    text: str
    related: tuple[str, ...] = ()


Judge = Callable[[SentFrames, Scene], Any]
"""From the frames of a cycle (r,), and where everyone is, to what `Effect` says: floats in [0, 1]
or booleans (r,), or one for all. It is called once a cycle, with the frames that it applies to."""


def _agrees(_value: Any, _key: str) -> Iterator[Disagreement]:
    return iter(())


@dataclass(frozen=True, slots=True, kw_only=True)
class LossModel:
    """A loss model, under a key of `channel.loss`.

    value: the type of what a scenario says there, as pydantic reads it; a model with several
    parameters has a Section. default: the value with which the model is not there. meaning: a
    sentence on the value, for the schema. start: from a value, keyed draws and the number of
    vehicles to a Judge. disagreements: from a value and its dotted key to what is impossible in it.
    place: among the keys; those without one come last, by name. purpose: what keys its draws;
    None: a number made of the key.
    """

    key: str
    value: Any
    default: Any
    effect: Effect
    start: Callable[[Any, Draws, int], Judge]
    meaning: str = ""
    disagreements: Callable[[Any, str], Iterator[Disagreement]] = _agrees
    place: int | None = None
    purpose: int | None = None

    @property
    def number(self) -> int:
        """The number that keys its draws; no other model or purpose has it."""
        if self.purpose is not None:
            return self.purpose
        return _FIRST_OWN + zlib.crc32(self.key.encode()) % (_NUMBERS - _FIRST_OWN)

    def judge(self, value: Any, seeds: Seeds, section: int = 0) -> Judge:
        """Return the model for the vehicles of these seeds; each `section` draws for itself."""
        draws = Draws(seeds, numbered(self.number, section))
        return self.start(value, draws, seeds.vehicles)
