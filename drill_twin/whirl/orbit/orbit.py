# SPDX-License-Identifier: Apache-2.0
"""Orbit of each mark over the last revolutions: radius, precession, regularity, contact.

Precession is the slope of the unwrapped angle against time (least squares over `Criteria.orbit_window` revolutions),
which depends neither on the sample rate nor on gaps of single bins. It is that of the asynchronous part during whirl,
otherwise that of the motion about the offset, so that a bow has a ratio of 1.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.history import ASYNCHRONOUS, MOVING, SYNCHRONOUS, History

FEWEST = 4
"""Fewest bins for a slope."""
RECENT = 4
"""Bins of the recent rotation: a quarter of a revolution, 2 s for a string that hardly rotates."""
SHORTEST_WINDOW = 0.9
"""Shortest window for which the estimates are meaningful [rev]."""
SMALLEST = 1e-3
"""Smallest radius with a precession, as a fraction of the clearance."""
OVER_NOISE = 2.0
"""Smallest radius with a precession, over the noise of a bin."""


class Orbit:
    """Orbits of the last revolutions; rows 0 and 1 are the asynchronous part and the motion about the offset."""

    def __init__(self, clearance: Array, criteria: Criteria) -> None:
        m = clearance.size
        self._criteria = criteria
        self._clearance = clearance
        self.rate = np.zeros((2, m))
        """Rate of the angle [rad/s], right-handed about +z."""
        self.radius = np.zeros((2, m))
        """Rms radius over the last revolution, noise removed, over the clearance."""
        self.window_radius = np.zeros(m)
        """Rms radius of the asynchronous part over the window, noise removed, over the clearance."""
        self.coherence = np.zeros((2, m))
        """1 for an angle of constant rate, 0 for a random one."""
        self.unevenness = np.zeros((2, m))
        """Rms deviation of the radius from its linear trend over its mean, noise removed."""
        self.synchronous = np.zeros(m)
        """Radius of the synchronous part over the window, over the clearance."""
        self.synchronous_share = np.zeros(m)
        """Its share of the rms radius of the motion about the offset."""
        self.contact = np.zeros(m)
        """Share of the window in contact with the wall."""
        self.seen: Mask = np.ones(m, bool)
        """Marks seen in at least half of the bins of the last revolution."""
        self.lag = 0.0
        """Mean delay of the estimates: half the length of the window [s]."""
        self.samples_per_revolution = math.inf
        """Samples in a revolution over the window, at most about `BINS`."""
        self.known = False
        """True once the window has the length of a revolution."""
        self.rotation = 0.0
        """Rotation over the window [rev/s], signed."""
        self.recent_rotation = 0.0
        """Rotation over the last quarter of a revolution [rev/s], signed."""

    def update(self, history: History, noise: Array) -> None:
        """Estimate with the newest bin; `noise` of a bin per axis over the clearance, shape (m,)."""
        n = history.bins_in(self._criteria.orbit_window)
        window = history.newest(n)
        time = history.time[window]
        # Across gaps too: samples may be so rare that each follows a gap.
        revolutions = history.revolutions[history.newest(min(max(n, 2), history.count))]
        span = float(revolutions[-1] - revolutions[0])
        self.known = n > 1 and span > SHORTEST_WINDOW
        self.samples_per_revolution = (max(n, 2) - 1) / span if span > 0.0 else math.inf
        self.lag = 0.5 * float(time[-1] - time[0])
        self.contact = history.contact[window].sum(axis=0) / n
        self.rotation = _mean_rate(history.angle[window], time)
        recent = history.newest(min(history.count, max(2, min(history.length, RECENT))))
        self.recent_rotation = _mean_rate(history.angle[recent], history.time[recent])
        vector = history.vector[window]
        size = np.abs(vector[:, :SYNCHRONOUS]) / self._clearance
        self.synchronous = np.abs(vector[:, SYNCHRONOUS].sum(axis=0)) / (n * self._clearance)
        power = size * size
        total = power.sum(axis=0) / n
        self.synchronous_share = self.synchronous / np.sqrt(total[MOVING] + 1e-300)
        self.window_radius = np.sqrt(np.maximum(total[ASYNCHRONOUS] - 2.0 * noise**2, 0.0))
        last = history.bins_in(1.0)
        self.seen = 2.0 * history.seen[history.newest(last)].sum(axis=0) >= last
        self.radius = np.sqrt(np.maximum(power[-last:].sum(axis=0) / last - 2.0 * noise**2, 0.0))
        if n >= FEWEST:
            self._regress(time, history.unwrapped[window], size, noise)

    def _regress(self, time: Array, unwrapped: Array, size: Array, noise: Array) -> None:
        """Fit straight lines to angle and radius over time; shapes (n,), (n, 2, m), (n, 2, m), (m,)."""
        n = time.size
        centred = time - time.sum() / n
        column = centred[:, None, None]
        weight = column / (centred * centred).sum()
        angle = unwrapped - unwrapped.sum(axis=0) / n
        self.rate = (weight * angle).sum(axis=0)
        angle -= column * self.rate
        total = size.sum(axis=0) + 1e-300
        self.coherence = np.hypot((size * np.cos(angle)).sum(axis=0), (size * np.sin(angle)).sum(axis=0)) / total
        mean = total / n
        deviation = size - mean
        deviation -= column * (weight * deviation).sum(axis=0)
        self.unevenness = np.sqrt(np.maximum((deviation * deviation).sum(axis=0) / n - noise**2, 0.0)) / mean

    @property
    def aliased(self) -> bool:
        """True if there are too few samples in a revolution to distinguish whirls."""
        return self.samples_per_revolution < self._criteria.fewest_samples

    def precession(self, whirling: Mask, noise: Array) -> tuple[Array, Array, Array]:
        """Precession [rev/s], its ratio to rotation (positive = forward) and the confidence in both, shape (m,)."""
        row = np.where(whirling, 0, 1)
        every = np.arange(row.size)
        rate, radius = self.rate[row, every] / math.tau, self.radius[row, every]
        coherence = self.coherence[row, every]
        seen = self.seen & (not self.aliased) & (radius > SMALLEST) & (radius > OVER_NOISE * noise) & (rate != 0.0)
        power = radius**2
        confidence = np.where(seen, coherence * power / np.maximum(power + 2.0 * noise**2, 1e-300), 0.0)
        sense = -1.0 if self.rotation < 0.0 else 1.0
        precession = np.where(seen, sense * rate, math.nan)
        rotating = abs(self.rotation) >= self._criteria.rest_rotation
        ratio = precession / abs(self.rotation) if rotating else np.full_like(precession, math.nan)
        return precession, ratio, confidence


def _mean_rate(angle: Array, time: Array) -> float:
    """Mean rate of an angle [rad] over time [s], in [rev/s]."""
    if time.size < 2:
        return 0.0
    return float((angle[-1] - angle[0]) / ((time[-1] - time[0]) * math.tau))
