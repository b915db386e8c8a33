# SPDX-License-Identifier: Apache-2.0
"""Likelihood of the rotor kit: what BASE, A007 and A015 say of vectors a unit of unbalance, and what they leave open.

Data of a probe are two complex numbers, (A007 - BASE) / 48 g mm and (A015 - BASE) / 48 g mm. The error of each mount
is shared through BASE; the model's own error is a factor 1 + d of each vector, d complex, alike for every speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drill_twin_evidence.rotor_kit.elements import Complex, Real
from drill_twin_evidence.rotor_kit.records import FITTED, Records
from drill_twin_evidence.rotor_kit.rig import PRIORS, Prior, Rigs

SPEED = 1005.0 * np.pi / 30  # [rad/s] nominal speed of the record
NOISE = (
    Prior(
        "scatter", "log-normal", 0.25, 0.5, "[um] of a vector between mounts; sessions' baselines move by 0.04 to 0.2"
    ),
    Prior("discrepancy", "log-normal", 0.02, 0.5, "of the model's vectors: supports that are not linear, hubs, bow"),
)
POOR = 4.0  # times the scatter at p1x, whose baseline moves by 0.9 um where the other probes' moves by 0.04 to 0.2
ALL = (*PRIORS, *NOISE)


@dataclass(frozen=True)
class Measured:
    """Vectors a unit of unbalance [um per g mm], shape (4, 2), the weights that gave them, and the base [um]."""

    sensitivity: Complex
    weights: Real  # [g mm] of disc 1 and disc 2
    base: Complex  # [um] shape (4,)

    @classmethod
    def of(cls, records: Records) -> Measured:
        """Return what the three fitted conditions measure."""
        base, first, second = (records.mean(name) for name in FITTED)
        loads = [records.unbalance[records.rows(name)[0]] for name in FITTED[1:]]
        if loads[0][1] != 0 or loads[1][0] != 0:
            raise ValueError(f"expected {FITTED[1]} on disc 1 alone and {FITTED[2]} on disc 2 alone, found {loads}")
        vectors = np.stack([(first - base) / loads[0][0], (second - base) / loads[1][1]], axis=1)
        return cls(vectors, np.abs([loads[0][0], loads[1][1]]), base)


def scatter_of(scatter: Real) -> Real:
    """Return the scatter between mounts of each probe [um], shape (n, 4)."""
    spread: Real = scatter[:, None] * np.array([POOR, 1.0, 1.0, 1.0])
    return spread


def covariances(measured: Measured, scatter: Real, discrepancy: Real) -> tuple[Real, Real]:
    """Return the covariance of the data's error and of the model's, each of shape (n, 4 probes, 2, 2)."""
    inverse = 1 / measured.weights
    shared = np.outer(inverse, inverse) + np.diag(inverse**2)
    data = scatter_of(scatter)[..., None, None] ** 2 * shared
    size = np.abs(measured.sensitivity) ** 2
    model = discrepancy[:, None, None, None] ** 2 * (size[:, :, None] * np.eye(2))
    return data, model


def noise_of(z: Real) -> tuple[Real, Real]:
    """Return scatter [um] and discrepancy of draws."""
    return NOISE[0].value(z[:, -2]), NOISE[1].value(z[:, -1])


def log_likelihood(z: Real, measured: Measured) -> Real:
    """Return the logarithm of the likelihood of draws of shape (n, unknowns); -inf where parts have no room."""
    answer = np.full(len(z), -np.inf)
    rigs = Rigs.of(z[:, :-2])
    room = np.flatnonzero(rigs.possible())
    if not len(room):
        return answer
    rigs = Rigs(rigs.values[room])
    wrong = measured.sensitivity - rigs.sensitivities([SPEED])[0]
    data, model = covariances(measured, *noise_of(z[room]))
    spread = data + model
    solved = np.linalg.solve(spread, wrong[..., None])[..., 0]
    answer[room] = -(np.conj(wrong) * solved).real.sum(axis=(1, 2)) - np.log(np.linalg.det(spread)).sum(axis=1)
    return answer


def corrections(z: Real, model_at_speed: Complex, measured: Measured, rng: np.random.Generator) -> Complex:
    """Return draws of the model's error 1 + d given the data, shape (n, 4, 2), to multiply vectors at every speed."""
    data, model = covariances(measured, *noise_of(z))
    wrong = measured.sensitivity - model_at_speed
    gain = model @ np.linalg.inv(data + model)
    mean = (gain @ wrong[..., None])[..., 0]
    left = model - gain @ model
    root = np.linalg.cholesky(left + 1e-15 * np.eye(2))
    noise = (rng.standard_normal(mean.shape) + 1j * rng.standard_normal(mean.shape)) / np.sqrt(2)
    result: Complex = 1 + (mean + (root @ noise[..., None])[..., 0]) / model_at_speed
    return result
