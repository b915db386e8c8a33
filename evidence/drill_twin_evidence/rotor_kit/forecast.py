# SPDX-License-Identifier: Apache-2.0
"""Predictive draws of vectors and of weights from the draws of a fit.

A vector is base + S U + error of the mount: S are the rig's vectors a unit of unbalance with the model's own error,
U the weights with their own error, base what the rig shows without weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin_evidence.rotor_kit.elements import Complex, Real
from drill_twin_evidence.rotor_kit.posterior import SPEED, Measured, corrections, noise_of, scatter_of
from drill_twin_evidence.rotor_kit.rig import Rigs

SPEEDS = (SPEED, 1206.0 * np.pi / 30)  # [rad/s]
RESIDUAL = 60.0  # [g mm] prior size of a disc's residual unbalance: some 50 g mm give the base
CARRIED = 0.01  # model's error that is not alike at both speeds, a part of a vector; chosen, not measured
MOUNT = 0.015  # error of a mounted weight, a part of it: 0.3 mm in a hole at 30 mm, 1 % of mass; chosen, not measured
SPEED_ERROR = 0.003  # a run's speed about the nominal one: records lie within 1,001 to 1,010 of 1,005 rpm
WEIGHTS = 45.0  # [g mm] prior size of a weight on a disc, real and imaginary part together


def complex_normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Complex:
    """Return complex numbers with mean square 1."""
    drawn: Complex = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)
    return drawn


@dataclass(frozen=True)
class Forecast:
    """Draws at 1,005 and 1,206 rpm, the draws along axis 1."""

    sensitivity: Complex  # [um per g mm] (2, n, 4, 2)
    base: Complex  # [um] (2, n, 4)
    scatter: Real  # [um] (n, 4)
    residual: Complex  # [g mm] (n, 2)

    @classmethod
    def of(cls, z: Real, measured: Measured, rng: np.random.Generator) -> Forecast:
        """Return the forecast of draws of the posterior, shape (n, unknowns)."""
        model = Rigs.of(z[:, :-2]).sensitivities(list(SPEEDS))
        right = corrections(z, model[0], measured, rng)
        sensitivity = model * right
        growth = model[1] / model[0]
        steps = SPEED_ERROR * rng.standard_normal((len(z), 1, 1))
        # A vector grows with the speed as a power that the two speeds of the model give.
        power = np.log(np.abs(growth)) / np.log(SPEEDS[1] / SPEEDS[0])
        sensitivity[1] *= (1 + steps * power) * (1 + CARRIED * complex_normal(rng, growth.shape))
        scatter = scatter_of(noise_of(z)[0])
        residual = weights_of(measured.base - np.zeros_like(scatter), sensitivity[0], scatter, RESIDUAL, rng)
        shown = (sensitivity @ residual[..., None])[..., 0]
        rest = measured.base - shown[0]
        kept = np.exp(rng.random((len(z), 1)) * np.log(np.abs(growth).mean()))  # from none to the growth of a weight's
        base = np.stack([measured.base + np.zeros_like(rest), shown[1] + rest * kept])
        return cls(sensitivity, base, scatter, residual)

    def net(self, unbalance: Complex, speed: int, rng: np.random.Generator) -> Complex:
        """Return what weights of shape (n or 1, 2) [g mm] add to the base [um], as mounted anew: shape (n, 4)."""
        mounted = unbalance * (1 + MOUNT * complex_normal(rng, self.residual.shape))
        clean = (self.sensitivity[speed] @ mounted[..., None])[..., 0]
        noise: Complex = clean + self.scatter * complex_normal(rng, self.scatter.shape)
        return noise

    def vectors(self, net: Complex, speed: int, rng: np.random.Generator) -> Complex:
        """Return the whole vectors [um]: base of another session and what the weights add."""
        moved: Complex = self.base[speed] + self.scatter * complex_normal(rng, self.scatter.shape)
        return moved + net

    def weights(self, vectors: Complex, rng: np.random.Generator) -> Complex:
        """Return draws of the weights [g mm] that a measured vector at 1,005 rpm of shape (4,) calls for, (n, 2)."""
        added = vectors - self.base[0]
        spread = np.sqrt(2) * self.scatter  # of the mount and of the session's base
        drawn = weights_of(added, self.sensitivity[0], spread, WEIGHTS, rng)
        return drawn * (1 + MOUNT * complex_normal(rng, drawn.shape))


def weights_of(added: Complex, sensitivity: Complex, spread: Real, size: float, rng: np.random.Generator) -> Complex:
    """Draw unbalances u [g mm] of a Gaussian prior of this size given added = S u + error, shapes (n, 4), (n, 4, 2)."""
    white = sensitivity / spread[..., None]
    turned = np.conj(white).swapaxes(1, 2)
    precision = turned @ white + np.eye(2) / size**2
    mean = np.linalg.solve(precision, turned @ (added / spread)[..., None])[..., 0]
    root = np.linalg.cholesky(np.linalg.inv(precision))
    drawn: Complex = mean + (root @ complex_normal(rng, mean.shape)[..., None])[..., 0]
    return drawn
