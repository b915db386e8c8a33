# SPDX-License-Identifier: Apache-2.0
"""Ensemble square-root Kalman filter, deterministic: the symmetric transform of Bishop, Etherton and Majumdar 2001.

Mean and spread of the members stand for mean and covariance. A measurement moves the mean and shrinks the spread by one
matrix of N by N members (Hunt, Kostelich and Szunyogh 2007, Eqs. 20 to 24, without localisation), whatever is to be
corrected: a state that has nothing in common with the measurement may be left out. In the linear Gaussian case without
process noise, with more members than states, mean and covariance are those of a Kalman filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array


@dataclass(frozen=True)
class Correction:
    """Correction of N members by m measured values.

    Attributes:
        weights: Part of each member's anomaly in the change of the mean, shape (N,).
        transform: From the anomalies before to those after, symmetric, shape (N, N).
        surprise: Squared innovation over its variance, summed: about m if members and noise explain it.
    """

    weights: Array
    transform: Array
    surprise: float

    def apply(self, values: Array) -> Array:
        """Corrected values of the members, of shape (N, ...)."""
        mean = values.mean(axis=0)
        corrected: Array = mean + np.tensordot(self.transform + self.weights, values - mean, axes=1)
        return corrected


def correction(predicted: Array, measured: Array, variance: Array) -> Correction:
    """Correction of members by measured values with independent errors.

    Args:
        predicted: What each member predicts for them, shape (N, m).
        measured: The values, shape (m,); NaN for one that is missing.
        variance: Of their errors, those of the model included, shape (m,).
    """
    known = np.isfinite(measured)
    deviation = np.sqrt(variance[known])
    mean = predicted[:, known].mean(axis=0)
    root = math.sqrt(len(predicted) - 1)
    scaled = (predicted[:, known] - mean) / (root * deviation)
    members, size, outputs = np.linalg.svd(scaled, full_matrices=False)
    innovation = (measured[known] - mean) / deviation
    along = outputs @ innovation
    left = 1.0 + size**2
    weights = members @ (size / left * along) / root
    transform = np.eye(len(predicted)) + (members * (1.0 / np.sqrt(left) - 1.0)) @ members.T
    surprise = float(innovation @ innovation - np.sum(size**2 / left * along**2))
    return Correction(weights, transform, surprise)
