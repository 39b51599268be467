"""A chain of links as one state, which batched Kalman filters estimate from whatever is heard.

The links reach from the vehicle m ahead of the host to the vehicle m behind it. Vehicle j of the
chain is the j-th from its front, so the host is vehicle m, and link j is between vehicles j and
j + 1. The state is x = [p_0, …, p_{L-1}, v_0, …, v_{L-1}, v]: gaps (m), relative speeds (m/s), and
the host's own speed (m/s), with L = 2 m. Each vehicle's acceleration drives the two links at its
ends, with opposite signs. So whatever is not known of it makes their errors correlated, and a
reading of one link corrects its neighbours too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """How a chain moves in a period: x' = F x + B a, with noise of covariance Q = Σ_j q_j Q_j.

    F (d, d); B (d, n) for the accelerations a (n,) of the n = 2 m + 1 vehicles; Q (n, d, d) for
    their variances q (n,), (m/s²)².
    """

    links: int
    F: Floats
    B: Floats
    Q: Floats

    @classmethod
    def of(cls, reach: int, period_s: float, *, coupled: bool) -> Model:
        """Return the model of m = `reach` links each way.

        If it is not coupled, noise of a vehicle counts in each link as if the others had none of
        it. Then the filter is one filter for each link, and one for the own speed.
        """
        links = 2 * reach
        speeds = np.zeros((links + 1, links + 1))  # from accelerations to those of the speeds in x
        speeds[:links] = np.eye(links, links + 1) - np.eye(links, links + 1, k=1)
        speeds[links, reach] = 1.0
        F = np.eye(2 * links + 1)
        F[:links, links : 2 * links] = period_s * np.eye(links)
        B = np.concatenate((0.5 * period_s**2 * speeds[:links], period_s * speeds))
        Q = np.einsum("ij,kj->jik", B, B)
        if not coupled:
            of_link = np.concatenate((np.arange(links), np.arange(links + 1)))
            Q = Q * (of_link[:, None] == of_link)
        return cls(links, F, B, Q)

    def after(self, x: Floats, a: Floats) -> Floats:
        """Return states x (M, d) a period later, with accelerations a (M, n), m/s²."""
        return np.asarray(x @ self.F.T + a @ self.B.T)

    def gap(self, link: int) -> Floats:
        """Return the row h of a reading of a gap: z = h x + error, (d,)."""
        return np.asarray(np.eye(len(self.F))[link])

    def relative_speed(self, link: int) -> Floats:
        """Return the row h of a reading of a relative speed, (d,)."""
        return np.asarray(np.eye(len(self.F))[self.links + link])

    def speed(self, vehicle: int) -> Floats:
        """Return the row h of a reading of a vehicle's speed: the own one and those of links."""
        host, h = self.links // 2, np.zeros(len(self.F))
        h[-1] = 1.0
        h[self.links + vehicle : self.links + host] = 1.0  # a vehicle ahead of the host
        h[self.links + host : self.links + vehicle] = -1.0  # one behind it
        return h


class Filters:
    """A Kalman filter for each of M hosts: states x (M, d) and covariances P (M, d, d)."""

    def __init__(self, model: Model, start: Floats, std: float, hosts: int) -> None:
        """Take the expected state at the start, (d,), and the standard deviation of all of it."""
        self._model = model
        self.x: Floats = np.tile(start, (hosts, 1))
        self.P: Floats = np.tile(std**2 * np.eye(len(start)), (hosts, 1, 1))

    def predict(self, a: Floats, variance: Floats) -> None:
        """Move on by a period: accelerations a (m/s²) and their variances, both (M, n)."""
        model = self._model
        self.x = model.after(self.x, a)
        noise = variance @ model.Q.reshape(len(model.Q), -1)
        self.P = model.F @ self.P @ model.F.T + noise.reshape(self.P.shape)

    def read(self, h: Floats, z: Floats, variance: float, heard: Bools) -> None:
        """Take in a reading z = h x + error (M,) for each host that has heard it, heard (M,).

        variance: that of the error, m² or (m/s)². The errors of readings are independent, so the
        readings can be taken in one by one.
        """
        seen = self.P @ h
        gain = seen * (heard / (seen @ h + variance))[:, None]
        self.x = self.x + gain * np.where(heard, z - self.x @ h, 0.0)[:, None]
        self.P -= gain[:, :, None] * seen[:, None, :]
