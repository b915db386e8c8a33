# SPDX-License-Identifier: Apache-2.0
"""Ensemble square-root Kalman filter, deterministic: the symmetric transform of Bishop, Etherton and Majumdar 2001.

Mean and spread of the members stand for mean and covariance. A measurement moves the mean and shrinks the spread by one
matrix of N by N members (Hunt, Kostelich and Szunyogh 2007, Eqs. 20 to 24, without localisation), whatever is to be
corrected: a state that has nothing in common with the measurement may be left out. In the linear Gaussian case without
process noise, with more members than states, mean and covariance equal the Kalman filter's.
"""

import math
from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from scipy.fft import dct

from drill_twin.core.arrays import Array, Mask


class Correction(NamedTuple):
    """Correction of N members by m measured values.

    Attributes:
        weights: Part of each member's anomaly in the change of the mean, shape (N,).
        transform: Matrix from the anomalies before to the anomalies after, symmetric, shape (N, N).
        directions: Effective number of directions that were measured, trace of the matrix from measured to fitted.
        near: True for the third of the members whose predictions are nearest to the measured values, shape (N,).
        surprise: Squared innovation over its variance, summed: about m if members and noise explain it.
    """

    weights: Array
    transform: Array
    directions: float
    near: Mask
    surprise: float

    def apply(self, values: Array) -> Array:
        """Corrected values of the members, of shape (N, ...)."""
        mean = values.mean(axis=0)
        return np.asarray(mean + np.tensordot(self.transform + self.weights, values - mean, axes=1))

    def apply_to_numbers(self, values: Array) -> Array:
        """Corrected numbers, of shape (N, d), as far as the members can tell them.

        * Numbers have no dynamics: what they lose of their spread by chance never comes back, and N members correlate
          with m samples even where a number does not act on them. So a correction is multiplied by 1 - 1 / F where
          F > 1, else by 0; F compares the explained with the remaining variance of a number, each by its degrees of
          freedom (James and Stein 1961; the adjusted coefficient of determination of Ezekiel 1930). With many members
          `apply` gives the same.
        * Where a number acts on the measured in a curve, the scatter about the regression is not everywhere the same.
          The scatter of the members nearest to the measured values counts where it is larger (heteroscedastic
          regression, as in approximate Bayesian computation: Blum and Francois 2010).
        """
        free = len(values) - 1.0 - self.directions
        before = values - values.mean(axis=0)
        after = self.transform @ before
        left = self.transform @ after  # residuals of the regression on the measured
        spread, remaining, near = (np.mean(part**2, axis=0) for part in (before, after, left[self.near]))
        if free <= 0.0 or self.directions == 0.0:
            return values
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = (spread / remaining - 1.0) * free / self.directions
            widened = np.sqrt(np.clip(near / np.mean(left**2, axis=0), 1.0, spread / remaining))
        learnt = ratio > 1.0
        moved = self.apply(values) - values
        mean = moved.mean(axis=0)
        kept = 1.0 - 1.0 / np.where(learnt, ratio, 1.0)
        corrected = (
            values.mean(axis=0) + kept * mean + (before + kept * (moved - mean)) * np.where(learnt, widened, 1.0)
        )
        return np.where(learnt, corrected, values)


def correction(predicted: Array, measured: Array, variance: Array) -> Correction:
    """Correction of members by measured values with independent errors.

    Args:
        predicted: Prediction of each member, shape (N, m).
        measured: The values, shape (m,); NaN for a missing value.
        variance: Variance of their errors, the model's errors included, shape (m,).
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
    distance = np.sum((root * size * members - along) ** 2 / left, axis=1)
    near = distance <= np.quantile(distance, 1.0 / 3.0)
    surprise = float(innovation @ innovation - np.sum(size**2 / left * along**2))
    return Correction(weights, transform, float(np.sum(size**2 / left)), near, surprise)


def corrections(predicted: Array, measured: Array, deviation: Array) -> list[Correction]:
    """Corrections by a window, one after the other: by the mean of each channel, then by what varies about it.

    Apart, a mean that numbers act on is not judged together with a motion whose phase they do not determine.

    Args:
        predicted: Channels of N members, shape (N, C, S).
        measured: Channels, shape (C, S); NaN where missing.
        deviation: Standard deviation of the errors of a sample, shape (C,).
    """
    parts: list[Array] = []
    for channel, known in enumerate(np.isfinite(measured)):
        if known.any():
            both = np.vstack((predicted[:, channel, known], measured[channel, known])) / deviation[channel]
            parts.append(dct(both, norm="ortho"))  # orthonormal: the errors stay independent
    found: list[Correction] = []
    for group in ([part[:, :1] for part in parts], [part[:, 1:] for part in parts]) if parts else ():
        members, rig = np.hstack(group)[:-1], np.hstack(group)[-1]
        found.append(correction(applied(found, members), rig, np.ones(rig.size)))
    return found


def applied(found: Sequence[Correction], values: Array) -> Array:
    """Values of the members, of shape (N, ...), after corrections one after the other."""
    return reduce(lambda corrected, each: each.apply(corrected), found, values)
