"""The record of a loss model: its key in a scenario, its checks and its maths."""

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

_FIRST_OWN: Final = 64  # lower numbers are explicit, in records and in `Purpose`
_NUMBERS: Final = 256


class Effect(Enum):
    """What a model decides about each frame.

    LOSS_CHANCE: the probability that it is lost. One draw per frame serves all such models, so a
    model that loses fewer frames loses a subset of those that another one loses. DAMAGE_CHANCE: the
    probability that it arrives damaged, with one draw as well. LOSS: whether it is lost, decided by
    the model's own draws.
    """

    LOSS_CHANCE = "loss chance"
    DAMAGE_CHANCE = "damage chance"
    LOSS = "loss"


class Disagreement(NamedTuple):
    """Values that are valid alone but not together: the key, the reason, and the other keys."""

    key: str
    text: str
    related: tuple[str, ...] = ()


Judge = Callable[[SentFrames, Scene], Any]
"""Maps the frames of a cycle (r,) and the scene to what `Effect` describes: floats in [0, 1] or
booleans, (r,), or one value for all. It is called once a cycle with the frames it applies to."""


def _agrees(_value: Any, _key: str) -> Iterator[Disagreement]:
    return iter(())


@dataclass(frozen=True, slots=True, kw_only=True)
class LossModel:
    """A loss model, under a key of `channel.loss`.

    value: the type of the value in a scenario, as pydantic reads it; a model with several
    parameters has a Section. default: the value that turns the model off. meaning: a sentence on
    the value, for the reference of keys. start: returns a Judge from a value, keyed draws and the
    number of vehicles. disagreements: yields the contradictions in a value, given its dotted key.
    place: its place in the list of keys; records without one come last, by name. purpose: the
    number that keys its draws; None: a number derived from the key.
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
        """The number that keys its draws, which no other model or purpose has."""
        if self.purpose is not None:
            return self.purpose
        return _FIRST_OWN + zlib.crc32(self.key.encode()) % (_NUMBERS - _FIRST_OWN)

    def judge(self, value: Any, seeds: Seeds, section: int = 0) -> Judge:
        """Return the Judge for the vehicles of these seeds; sections have independent draws."""
        draws = Draws(seeds, numbered(self.number, section))
        return self.start(value, draws, seeds.vehicles)
