# SPDX-License-Identifier: Apache-2.0
"""When did a radius first cross its threshold? Asked once, when it is certain that it did.

Looking back from a certain onset, the crossing is the change point that best parts bins below the threshold from bins
above it (Page 1954, in its log-likelihood form): a bin above speaks for "already crossed" by 1, a bin below speaks
against it by the square of its distance in units of the noise. Without noise this is exactly the last crossing; with
noise, dips that noise explains do not delay it.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray

NOISE_FLOOR = 2e-4
"""Least noise of a radius, over the clearance: bins are not more exact than this."""
STRONGEST = 1e4
"""Largest weight of a single bin against a crossing."""


def smoothed_radius(vector: ComplexArray, half_width: int, noise: float) -> Array:
    """Radius after a centred average of 2 half_width + 1 bins, noise removed, shape (n,).

    `vector` is turned back by the precession, shape (n,), so that the average takes nothing off the orbit; `noise` is
    that of a bin per axis, in the same unit. At the ends the average is over the bins there are.
    """
    n = vector.size
    sums = np.concatenate(([0.0], np.cumsum(vector)))
    low = np.maximum(np.arange(n) - half_width, 0)
    high = np.minimum(np.arange(n) + half_width + 1, n)
    width = high - low
    mean = (sums[high] - sums[low]) / width
    radius: Array = np.sqrt(np.maximum(np.abs(mean) ** 2 - 2.0 * noise**2 / width, 0.0))
    return radius


def crossing_time(time: Array, radius: Array, threshold: float, noise: float) -> float:
    """Time [s] at which `radius` crossed `threshold` for good; `noise` is that of the radius. All shapes (n,).

    Both in one unit (fractions of the clearance). The last bin is taken to lie above the threshold.
    """
    scale = max(noise, NOISE_FLOOR)
    below = radius < threshold
    evidence = np.where(below, -np.minimum(((threshold - radius) / scale) ** 2 + 1e-9, STRONGEST), 1.0)
    backward = np.cumsum(evidence[::-1])[::-1]
    first = int(np.argmax(backward))
    if first == 0 or not below[first - 1]:
        return float(time[first])
    low, high = float(radius[first - 1]), float(radius[first])
    share = (threshold - low) / (high - low) if high > low else 1.0
    share = min(max(share, 0.0), 1.0)
    return math.fsum((float(time[first - 1]) * (1.0 - share), float(time[first]) * share))
