"""Loss of frames from received power: two slopes, shadowing, vehicles in the way, fading."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc

from zenvoy.channel.rows import Rows, Scene
from zenvoy.channel.shadowing import Shadowing
from zenvoy.scenarios import PathLoss

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

REFERENCE_M: Final = 10.0
"""Distance of the reference loss; nothing is taken to be nearer."""


class PathLossModel:
    """Probabilities of loss under one section of path loss, among `size` vehicles."""

    def __init__(self, model: PathLoss, seed: int, size: int, number: int = 0) -> None:
        self._model = model
        self._shadowing = Shadowing(model.shadowing_db, model.decorrelation_m, seed, size, number)

    def probability(self, rows: Rows, scene: Scene) -> Floats:
        """That a frame is lost, (r,)."""
        model = self._model
        margin_db = (
            model.transmit_dbm
            - path_loss_db(rows.distance, model)
            - model.blockage_db * between(rows, scene)
            + self._shadowing.of(rows, scene)
            - model.sensitivity_dbm
        )
        return outage(margin_db, model.fading_m)


def path_loss_db(distance: Floats, model: PathLoss) -> Floats:
    """Two slopes over the logarithm of distance, m (as in Abbas et al. 2015, Eq. 5)."""
    d = np.maximum(distance, REFERENCE_M)
    near = model.exponent * np.log10(np.minimum(d, model.break_m) / REFERENCE_M)
    far = model.exponent_beyond * np.log10(np.maximum(d, model.break_m) / model.break_m)
    return np.asarray(model.reference_loss_db + 10.0 * (near + far))


def outage(margin_db: Floats, fading_m: float | None) -> Floats:
    """Probability that the power falls below what the receiver needs, its mean `margin_db` above.

    Without fading it is 0 or 1. Under Nakagami fading of shape m the power is gamma distributed
    with shape m about its mean.
    """
    if fading_m is None:
        return (margin_db < 0.0).astype(np.float64)
    return np.asarray(gammainc(fading_m, fading_m * 10.0 ** (-0.1 * margin_db)))


def between(rows: Rows, scene: Scene) -> Ints:
    """How many vehicles stand between sender and receiver, (r,); on the ring on the shorter way."""
    n = len(scene.position)
    place = scene.position
    if scene.ring_length_m is not None:
        place = np.mod(place, scene.ring_length_m)
    rank = np.empty(n, dtype=np.int64)
    rank[np.argsort(place, kind="stable")] = np.arange(n)
    ahead = rank[rows.source] - rank[rows.destination]
    if scene.ring_length_m is None:
        return np.asarray(np.abs(ahead) - 1)
    forward_m = np.mod(place[rows.source] - place[rows.destination], scene.ring_length_m)
    way = np.where(forward_m <= scene.ring_length_m - forward_m, ahead, -ahead)
    return np.asarray(np.mod(way, n) - 1)
