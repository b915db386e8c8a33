# SPDX-License-Identifier: Apache-2.0
"""The orbit of each mark over the last revolutions: radius, precession, regularity, contact.

Precession is the slope of the unwrapped angle against time (least squares over `Criteria.orbit_window` revolutions),
for which neither the rate of the samples nor gaps of single bins matter. It is taken from the asynchronous part
during whirl, and from all that moves otherwise: a bow then shows its ratio of 1.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, MOVING, SYNCHRONOUS, History

FEWEST = 4
"""Bins needed for a slope."""
RECENT = 4
"""Bins of the recent rotation: a quarter of a revolution, 2 s for a string that hardly turns."""
SEEN = 0.9
"""Revolutions that make the numbers of the window worth telling [rev]."""
SMALLEST = 1e-3
"""Smallest orbit with a precession, as a fraction of the clearance."""
OVER_NOISE = 2.0
"""And over the noise of a bin."""


class Orbit:
    """Features of the last revolutions; rows 0 and 1 are the asynchronous and the moving part."""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self.slope = np.zeros((2, m))
        """Rate of the angle [rad/s], right-handed about +z."""
        self.radius = np.zeros((2, m))
        """Rms radius over the last revolution, noise removed, over the clearance."""
        self.lasting = np.zeros(m)
        """Rms radius of the asynchronous part over the window, noise removed, over the clearance."""
        self.coherence = np.zeros((2, m))
        """1 when the angle keeps a steady pace, 0 when it has none."""
        self.unevenness = np.zeros((2, m))
        """Rms deviation of the radius from its linear trend over its mean, noise removed."""
        self.synchronous = np.zeros(m)
        """Radius of the synchronous part over the window, over the clearance."""
        self.purity = np.zeros(m)
        """Its share of the rms radius of all that moves."""
        self.contact = np.zeros(m)
        """Share of the window in contact with the wall."""
        self.seen: Mask = np.ones(m, bool)
        """Marks seen in at least half of the bins of the last revolution."""
        self.lag = 0.0
        """Half the length of the window: what it shows lies so far back on average [s]."""
        self.sampling = math.inf
        """Samples in a revolution over the window, where they are fewer than the bins; else the bins."""
        self.known = False
        """Whether a revolution has been seen."""
        self.rotation = 0.0
        """Rotation over the window [rev/s], signed."""
        self.recent_rotation = 0.0
        """Rotation over the last quarter of a revolution [rev/s], signed."""

    def update(self, history: History, noise: Array) -> None:
        """Takes the newest bin into account; `noise` of a bin per axis over the clearance, shape (m,)."""
        n = history.span(self._criteria.orbit_window)
        window = history.newest(n)
        time = history.time[window]
        # Over a gap too: samples may be so rare that each follows a gap.
        seen = history.newest(min(max(n, 2), history.count))
        span = float(history.travel[seen][-1] - history.travel[seen][0])
        self.known = n > 1 and span > SEEN
        self.sampling = (max(n, 2) - 1) / span if span > 0.0 else math.inf
        self.lag = 0.5 * float(time[-1] - time[0])
        self.contact = history.contact[window].sum(axis=0) / n
        self.rotation = _pace(history.angle[window], time)
        recent = history.newest(min(history.count, max(2, min(history.length, RECENT))))
        self.recent_rotation = _pace(history.angle[recent], history.time[recent])
        vector = history.vector[window]
        size = np.abs(vector[:, :SYNCHRONOUS]) / self._clearance
        self.synchronous = np.abs(vector[:, SYNCHRONOUS].sum(axis=0)) / (n * self._clearance)
        power = size * size
        total = power.sum(axis=0) / n
        self.purity = self.synchronous / np.sqrt(total[MOVING] + 1e-300)
        self.lasting = np.sqrt(np.maximum(total[ASYNCHRONOUS] - 2.0 * noise**2, 0.0))
        last = history.span(1.0)
        self.seen = 2.0 * history.seen[history.newest(last)].sum(axis=0) >= last
        self.radius = np.sqrt(np.maximum(power[-last:].sum(axis=0) / last - 2.0 * noise**2, 0.0))
        if n >= FEWEST:
            self._regress(time, history.turned[window], size, noise)

    def _regress(self, time: Array, turned: Array, size: Array, noise: Array) -> None:
        n = time.size
        centred = time - time.sum() / n
        column = centred[:, None, None]
        lever = column / (centred * centred).sum()
        angle = turned - turned.sum(axis=0) / n
        self.slope = (lever * angle).sum(axis=0)
        angle -= column * self.slope
        total = size.sum(axis=0) + 1e-300
        self.coherence = np.hypot((size * np.cos(angle)).sum(axis=0), (size * np.sin(angle)).sum(axis=0)) / total
        mean = total / n
        off = size - mean
        off -= column * (lever * off).sum(axis=0)
        self.unevenness = np.sqrt(np.maximum((off * off).sum(axis=0) / n - noise**2, 0.0)) / mean

    @property
    def aliased(self) -> bool:
        """Whether the samples are too few for the rotation to tell one whirl from another."""
        return self.sampling < self._criteria.fewest_samples

    def precession(self, whirling: Mask, noise: Array) -> tuple[Array, Array, Array]:
        """Precession [rev/s] and its ratio to rotation, positive = forward, and the confidence in them, shape (m,)."""
        row = np.where(whirling, 0, 1)
        every = np.arange(row.size)
        slope, radius = self.slope[row, every] / math.tau, self.radius[row, every]
        coherence = self.coherence[row, every]
        seen = self.seen & (not self.aliased) & (radius > SMALLEST) & (radius > OVER_NOISE * noise) & (slope != 0.0)
        power = radius**2
        confidence = np.where(seen, coherence * power / np.maximum(power + 2.0 * noise**2, 1e-300), 0.0)
        sense = -1.0 if self.rotation < 0.0 else 1.0
        precession = np.where(seen, sense * slope, math.nan)
        turning = abs(self.rotation) >= self._criteria.rest_rotation
        ratio = precession / abs(self.rotation) if turning else np.full_like(precession, math.nan)
        return precession, ratio, confidence


def _pace(angle: Array, time: Array) -> float:
    """Mean rate of an angle [rad] over time [s], in [rev/s]."""
    if time.size < 2:
        return 0.0
    return float((angle[-1] - angle[0]) / ((time[-1] - time[0]) * math.tau))
