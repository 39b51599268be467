"""Loss of frames from received power: two slopes, shadowing, vehicles in the way, fading.

`scipy.special` loads when it is first used, because it loads more slowly than everything else that
a scenario needs.
"""

from __future__ import annotations

from typing import Annotated, Final

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.distance import forward
from zenvoy.links.loss_model import Effect, Judge, LossModel
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.links.shadowing import Shadowing
from zenvoy.values.section import LARGEST, Positive, Section

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

Decibels = Annotated[float, Field(ge=-1000, le=1000)]
Exponent = Annotated[float, Field(ge=0, le=10)]

REFERENCE_M: Final = 10.0
"""Distance of the reference loss; shorter distances count as this one."""


class PathLoss(Section):
    """Loss from received power: two-slope path loss, shadowing, vehicles in the way, fading.

    A frame is lost if its power is below sensitivity_dbm. reference_loss_db: the loss at 10 m, from
    where it grows with exponent, and beyond break_m with exponent_beyond. shadowing_db: standard
    deviation of shadowing, whose correlation falls to 1/e after decorrelation_m. blockage_db: loss
    for each vehicle in between. fading_m: shape of Nakagami fading, drawn for each frame (1:
    Rayleigh); null: no fading.
    """

    transmit_dbm: Decibels = 23.0
    """Power of the transmitter, with its antenna."""
    sensitivity_dbm: Decibels = -88.0
    """Power below which a frame is lost."""
    reference_loss_db: Decibels = 66.1
    """Path loss at 10 m."""
    exponent: Exponent = 1.66
    """Exponent of the path loss from 10 m to break_m."""
    break_m: Annotated[float, Field(ge=10, le=LARGEST)] = 104.0
    """Distance at which the second slope begins."""
    exponent_beyond: Exponent = 2.88
    """Exponent of the path loss beyond break_m."""
    shadowing_db: Annotated[float, Field(ge=0, le=100)] = 3.95
    """Standard deviation of shadowing."""
    decorrelation_m: Positive = 25.0
    """Distance after which the correlation of shadowing has fallen to 1/e."""
    blockage_db: Annotated[float, Field(ge=0, le=1000)] = 9.0
    """Loss for each vehicle in between."""
    fading_m: Annotated[float, Field(ge=0.5, le=1000)] | None = None
    """Shape of Nakagami fading, drawn for each frame (1: Rayleigh); null: no fading."""


def start(model: PathLoss, draws: Draws, size: int) -> Judge:
    """Return the probability that a frame is lost, (r,)."""
    shadowing = Shadowing(model.shadowing_db, model.decorrelation_m, draws, size)

    def probability(frames: SentFrames, scene: Scene) -> Floats:
        margin_db = (
            model.transmit_dbm
            - path_loss_db(frames.distance, model)
            - model.blockage_db * between(frames, scene)
            + shadowing.of(frames, scene)
            - model.sensitivity_dbm
        )
        return outage(margin_db, model.fading_m)

    return probability


def path_loss_db(distance: Floats, model: PathLoss) -> Floats:
    """Return the path loss, dB: two slopes over the logarithm of the distance (m).

    See Abbas et al. 2015, Eq. 5.
    """
    d = np.maximum(distance, REFERENCE_M)
    near = model.exponent * np.log10(np.minimum(d, model.break_m) / REFERENCE_M)
    far = model.exponent_beyond * np.log10(np.maximum(d, model.break_m) / model.break_m)
    return np.asarray(model.reference_loss_db + 10.0 * (near + far))


def outage(margin_db: Floats, fading_m: float | None) -> Floats:
    """Return the probability that the power falls below the receiver's sensitivity.

    margin_db: by how much the mean power exceeds the sensitivity, dB. Without fading the result is
    0 or 1. Under Nakagami fading with shape m, the power has a gamma distribution with shape m.
    """
    if fading_m is None:
        return (margin_db < 0.0).astype(np.float64)
    return np.asarray(scipy.special.gammainc(fading_m, fading_m * 10.0 ** (-0.1 * margin_db)))


def between(frames: SentFrames, scene: Scene) -> Ints:
    """Return how many vehicles are between sender and receiver, (r,), on the shorter way."""
    n = len(scene.position)
    place = scene.position
    if scene.ring_length_m is not None:
        place = np.mod(place, scene.ring_length_m)
    rank = np.empty(n, dtype=np.int64)
    rank[np.argsort(place, kind="stable")] = np.arange(n)
    ahead = rank[frames.source] - rank[frames.destination]
    if scene.ring_length_m is None:
        return np.asarray(np.abs(ahead) - 1)
    forward_m = forward(place[frames.source], place[frames.destination], scene.ring_length_m)
    way = np.where(forward_m <= scene.ring_length_m - forward_m, ahead, -ahead)
    return np.asarray(np.mod(way, n) - 1)


LOSS = LossModel(
    key="path_loss",
    value=PathLoss | None,
    default=None,
    effect=Effect.LOSS_CHANCE,
    start=start,
    meaning="Loss from received power; `{}`: with the defaults of [The channel](channel.md).",
    place=2,
    purpose=26,
)
