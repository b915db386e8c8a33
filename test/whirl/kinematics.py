# SPDX-License-Identifier: Apache-2.0
"""Labelled motions of a string in a hole: known orbits, and what a camera would make of them.

The truth is computed here from the noise-free parts of the motion and shares nothing with `drill_twin.whirl`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drill_twin.whirl import Analyzer, MarkInfo

TURN = 2.0 * np.pi
BENCH = MarkInfo("mark_3", 0.5, "wall", 0.00825, 0.08175)
MARKS = (
    MarkInfo("mark_1", 4.4, "wall", 0.00825, 0.08175),
    MarkInfo("mark_2", 2.5, "wall", 0.00825, 0.08175),
    BENCH,
    MarkInfo("mark_4", 0.5, "centre", 0.00825, 0.08175),
)


@dataclass(frozen=True)
class Motion:
    """A sampled motion; n samples, m marks."""

    marks: tuple
    time: np.ndarray  # (n,) [s]
    spin: np.ndarray  # (n, m) [rad]
    top_speed: np.ndarray  # (n,) [rad/s]
    whirl: np.ndarray  # (n, m) complex: the asynchronous part [m]
    rest: np.ndarray  # (n, m) complex: offset and synchronous part [m]
    noise: np.ndarray  # (n, m) complex [m]
    contact: np.ndarray | None = None  # (n, m) [N]

    @property
    def stamps(self):
        return np.round(self.time * 1e9).astype(np.int64)

    @property
    def centre(self):
        return self.whirl + self.rest

    @property
    def positions(self):
        arm = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in self.marks])
        z = self.centre + arm * np.exp(1j * self.spin) + self.noise
        place = np.zeros((*z.shape, 3))
        place[..., 0], place[..., 1] = z.real, z.imag
        place[..., 2] = -5.0
        return place

    def keep(self, which):
        """The same motion with other samples: an index array or a mask."""
        force = None if self.contact is None else self.contact[which]
        return Motion(
            self.marks,
            self.time[which],
            self.spin[which],
            self.top_speed[which],
            self.whirl[which],
            self.rest[which],
            self.noise[which],
            force,
        )

    def with_noise(self, fraction, seed):
        """White noise of this rms per axis over the clearance, on every mark."""
        clearance = np.array([mark.clearance for mark in self.marks])
        rng = np.random.default_rng(seed)
        noise = rng.normal(size=self.whirl.shape) + 1j * rng.normal(size=self.whirl.shape)
        return replace(self, noise=noise * fraction * clearance)

    def true_onset(self, mark=0, level=0.05):
        """First time from which the asynchronous radius stays over `level` of the clearance for a revolution."""
        angle = np.abs(np.concatenate(([0.0], np.cumsum(np.diff(self.time) * self.top_speed[1:]))))
        above = np.abs(self.whirl[:, mark]) > level * self.marks[mark].clearance
        start = None
        for i, high in enumerate(above):
            if not high:
                start = None
            elif start is None:
                start = i
            elif angle[i] - angle[start] >= TURN:
                return float(self.time[start])
        return None


def clock(rate, seconds, *, jitter=0.0, seed=0):
    """Sample times [s]; jitter is the rms deviation over the period."""
    time = np.arange(round(rate * seconds)) / rate
    if jitter:
        time = np.sort(time + np.random.default_rng(seed).normal(size=time.size) * jitter / rate)
        time -= time[0]
    return time


def turning(time, speed, ramp=0.5):
    """Angle [rad] and rate [rad/s] of a rotation that ramps up to `speed` [rev/s] in a smooth step."""
    if ramp == 0.0:
        return TURN * speed * time, np.full_like(time, TURN * speed)
    x = np.clip(time / ramp, 0.0, 1.0)
    rate = TURN * speed * x * x * (3 - 2 * x)
    angle = TURN * speed * np.where(time < ramp, ramp * (x**3 - 0.5 * x**4), time - 0.5 * ramp)
    return angle, rate


def motion(time, *, speed=2.0, ramp=0.5, marks=(BENCH,), bow=0.0, bow_angle=0.7, offset=0.0, whirl=None, twist=0.3):
    """A motion; bow [of the clearance] may be an array over time; `whirl(time, angle)` gives the asynchronous part of
    each mark [of the clearance], shape (n,) or (n, m)."""
    angle, rate = turning(time, speed, ramp)
    m = len(marks)
    clearance = np.array([mark.clearance for mark in marks])
    spin = angle[:, None] - twist * np.arange(m)
    orbit = np.zeros((time.size, m), complex)
    if whirl is not None:
        part = np.asarray(whirl(time, angle))
        orbit = orbit + (part[:, None] if part.ndim == 1 else part)
    size = np.broadcast_to(np.asarray(bow, float), time.shape)[:, None]
    rest = size * np.exp(1j * (spin + bow_angle)) + np.broadcast_to(np.asarray(offset, complex), (time.size, m))
    noise = np.zeros_like(orbit)
    return Motion(tuple(marks), time, spin, rate, orbit * clearance, rest * clearance, noise)


def growth(start, level, rate, ratio, *, limit=0.8, angle=0.4):
    """An orbit that grows by exp(rate t) through `level` at `start` [s] up to `limit`, at `ratio` of the rotation."""

    def whirl(time, turned):
        radius = level * np.exp(np.minimum(rate * (time - start), 50.0))
        radius /= 1.0 + radius / limit
        return radius * np.exp(1j * (ratio * turned + angle))

    return whirl


class Found(Sequence):
    """Findings after each sample of a block, made where they are asked for; their `quality` is of an earlier sample."""

    def __init__(self, rows):
        self._rows, self._changed = rows, sorted(rows.changes)

    def __len__(self):
        return len(self._rows.stamps)

    def __getitem__(self, number):
        rows, number = self._rows, range(len(self))[number]
        last = bisect_right(self._changed, number)
        stamp, (radius, precession, ratio, confidence) = rows.stamps[number], rows.values[number].T
        return replace(
            rows.changes[self._changed[last - 1]] if last else rows.before, stamp_ns=stamp, time_s=stamp * 1e-9,
            orbit_radius=radius, precession=precession, ratio=ratio, confidence=confidence,
            bit_index=float(rows.bit_index[number]),
        )  # fmt: skip


def play(moved, analyzer=None, *, spin=True, force=False):
    """Pushes a motion through an analyzer at once; the analyzer and the findings after each sample.

    A block gives the bits that its samples give (test_findings_values.py), in a tenth of the time.
    """
    analyzer = analyzer or Analyzer(moved.marks)
    turned, pull = moved.spin if spin else None, moved.contact if force else None
    return analyzer, Found(analyzer.push_block(moved.stamps, moved.positions, turned, moved.top_speed, pull))


def play_each(moved, *, spin=True):
    """As `play`, sample by sample."""
    analyzer, positions, found = Analyzer(moved.marks), moved.positions, []
    for i, stamp in enumerate(moved.stamps.tolist()):
        turned = moved.spin[i] if spin else None
        found.append(analyzer.push(stamp, positions[i], turned, float(moved.top_speed[i])))
    return analyzer, found
