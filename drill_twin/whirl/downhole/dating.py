# SPDX-License-Identifier: Apache-2.0
"""Time of the onset of a whirl from the readings of a sub, found backwards once the whirl is detected.

A causal high pass turns and shortens slow orbits. Looking back, the position is instead the acceleration integrated
twice less the most probable drift, from the revolutions before and after the onset together: Gaussian regression
(Rasmussen and Williams 2006, chapter 2) with

* a drift: position, velocity and mean acceleration at the start (in an inclined hole its rate too), what is constant in
  the frame of the string, and the integrals of the white noise of accelerometers and gyroscopes;
* a motion whose radius varies with time and is found by iteration, and which is a line in its spectrum, as a mode that
  grows or decays, and for a small part without a frequency, as a string that moves aside. The line has whichever of a
  few frequencies makes the readings most probable.

The bounds of the time follow from the bounds of the radius: standard deviations of the position, and an error of the
model of the motion. A section that creeps aside before it whirls moves less than the drift of a sub. So the motion may
be as large as the threshold at the onset, less by a factor e in every two revolutions before it, even where the
readings show no motion: where the readings do not rule such a motion out, the bounds allow for it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import criteria
from drill_twin.whirl.downhole.high_pass import GRAVITY, ToolNoise
from drill_twin.whirl.downhole.motion import MotionRecord

BEFORE = 24.0
"""Length of the record before the onset [rev].

A constant below that states no reason was chosen, not measured; `make sub-onsets` judges the constants together."""
QUIET_UNTIL = 6.0
"""The motion is first taken to be small until so long before the onset [rev]."""
QUIET, LARGEST = 0.12, 20.0
"""Least and largest standard deviation of the motion, over the threshold of an onset."""
CREEP = 2.0
"""Before the onset the standard deviation of the motion is at least the threshold, e times less in this time [rev]."""
RATIOS = (0.12, 0.2, 0.3, 0.4, 0.55, 0.75, 1.05, 1.4)
"""Frequencies of the motion over the rotation [-]."""
LINE_MEMORY, ASIDE_MEMORY = 3.0, 1.0
"""Memory of the line, and of the motion without a frequency [rev]."""
ASIDE = 0.5
"""Share of the motion without a frequency in its variance."""
PER_REVOLUTION = 8
"""Samples of a revolution."""
ITERATIONS = 5
"""Iterations of the radius; chosen, not measured."""
LEANING = 0.1
"""Mean acceleration from which a bias of the gyroscope turns gravity enough to be fitted [m/s^2]."""
WITHIN = 1.0
"""An onset is dated where its time is known within this [rev]."""
DEVIATIONS, RADIUS_ERROR, TIME_ERROR = 1.5, 0.2, 0.25
"""Error of the radius in standard deviations and as a share, and what is added to the error of the time [rev]."""
WIDER = 1.8
"""Factor by which the bounds that follow are widened. Chosen with the three numbers above on 250 random runs and 350
random motions, made as in `make sub-onsets`, which judges the numbers on other runs and motions."""
SHORTER, LONGER = 0.5, 2.0
"""Earliest and latest time: the radius stays above its threshold for so long [rev]."""
AS_PROBABLE = 3.0
"""Lines whose log likelihood is less by at most this bound the time too."""


class Date(NamedTuple):
    """Time of an onset from the readings of a sub."""

    time_s: float
    """Most probable time [s]."""
    earliest_s: float
    latest_s: float
    """Bounds: in nine of ten cases or more the true onset is no farther off than the farther one [s]."""
    dated: bool
    """True if both bounds are within a revolution of the time."""
    first: bool
    """True if the time is in the first revolution of the record: the onset may be before."""


class _Motion(NamedTuple):
    """Motion over a record of n samples, in units of the threshold of an onset."""

    likelihood: float
    position: ComplexArray
    deviation: Array  # standard deviation of the position on an axis


def date_onset(record: MotionRecord, clearance: float, noise: ToolNoise, begin: float, detected: float) -> Date:
    """Time at which the radius crossed the threshold of an onset.

    Args:
        record: The readings.
        clearance: Lateral clearance of the section [m].
        noise: Noise of the instruments.
        begin: Time at which it may have crossed [s].
        detected: Time of the detection [s].
    """
    begun, end = np.interp([begin, detected], record.stamp, record.revolutions).tolist()
    rows = slice(*np.searchsorted(record.revolutions, [begun - BEFORE, end]).tolist())
    revolutions = record.revolutions[rows]
    spacing = max(1, int(revolutions.size / (PER_REVOLUTION * (revolutions[-1] - revolutions[0]))))
    at = np.arange(revolutions.size - 1, -1, -spacing)[::-1]
    revolutions = revolutions[at]
    limit = criteria.ONSET_RADIUS * clearance
    motions = _probable_motions(record, rows, at, revolutions, limit, noise, begun)
    last, sustain = float(revolutions[-1]), criteria.SUSTAIN
    found = _first_crossing(np.abs(motions[0].position), revolutions, sustain)
    crossed = last if found is None else found
    bounds = [crossed - TIME_ERROR, crossed + TIME_ERROR]
    for motion in motions:
        radius = np.abs(motion.position)
        early = _first_crossing((1.0 + RADIUS_ERROR) * radius + DEVIATIONS * motion.deviation, revolutions, SHORTER)
        late = _first_crossing((1.0 - RADIUS_ERROR) * radius - DEVIATIONS * motion.deviation, revolutions, LONGER)
        bounds[0] = min(bounds[0], (crossed if early is None else early) - TIME_ERROR)
        bounds[1] = max(bounds[1], (last if late is None else late) + TIME_ERROR)
    bounds = [crossed + WIDER * (bound - crossed) for bound in bounds]
    first = found is not None and bool(found - revolutions[0] < WITHIN)
    dated = found is not None and not first and max(crossed - bounds[0], bounds[1] - crossed) <= WITHIN
    turn = float(record.stamp[-1] - record.stamp[0]) / float(record.revolutions[-1] - record.revolutions[0])  # s
    time, earliest = np.interp([crossed, bounds[0]], record.revolutions, record.stamp).tolist()
    return Date(time, earliest, time + (bounds[1] - crossed) * turn, dated, first)


def _probable_motions(
    record: MotionRecord,
    rows: slice,
    at: NDArray[np.int64],
    revolutions: Array,
    limit: float,
    noise: ToolNoise,
    begun: float,
) -> list[_Motion]:
    """Motions with lines under which the readings of some rows are probable, at samples of the rows; best first."""
    acceleration = record.acceleration[rows]
    interval = float(np.mean(np.diff(record.stamp[rows])))
    integral, along = (_twice(part)[at] * interval**2 / limit for part in (acceleration, record.turn[rows]))
    time = np.asarray((at + 1.0) * interval, float)
    quiet = acceleration[: max(PER_REVOLUTION, int(np.searchsorted(record.revolutions[rows], begun - QUIET_UNTIL)))]
    powers = 4 if abs(quiet.mean()) > LEANING else 3
    known = np.polynomial.legendre.legvander(2.0 * time / time[-1] - 1.0, powers - 1)
    columns = np.column_stack([known + 0j, along / np.abs(along).max()])
    drift = _drift(time, interval, noise) / limit**2
    lag = np.abs(np.subtract.outer(revolutions, revolutions))
    least = np.maximum(QUIET, np.exp(np.minimum(revolutions - begun, 0.0) / CREEP))
    first = np.where(revolutions < begun - QUIET_UNTIL, least, LARGEST)
    width = max(1, round(revolutions.size / float(revolutions[-1] - revolutions[0])))
    found = []
    for ratio in RATIOS:
        line = np.exp(-lag / LINE_MEMORY) * np.cos(math.tau * ratio * lag)
        correlation = (1.0 - ASIDE) * line + ASIDE * np.exp(-lag / ASIDE_MEMORY)
        size = first
        for _ in range(ITERATIONS):
            motion = _regress(integral, columns, drift, correlation * np.outer(size, size))
            power = _running_mean(np.abs(motion.position) ** 2, width)
            size = np.minimum(np.sqrt(least**2 + 0.5 * power), LARGEST)
        found.append(motion)
    found.sort(key=lambda motion: -motion.likelihood)
    return [motion for motion in found if motion.likelihood >= found[0].likelihood - AS_PROBABLE]


def _regress(integral: ComplexArray, columns: ComplexArray, drift: Array, motion: Array) -> _Motion:
    """Motion in an integral that has known columns of any size, a drift and a motion of given covariances."""
    from scipy.linalg import cholesky, solve_triangular  # takes 0.2 s, which a run without subs does not need

    total = drift + motion
    total[np.diag_indices_from(total)] += 1e-10 + 1e-12 * np.diag(total)
    factor = cholesky(total, lower=True, check_finite=False)
    right = np.column_stack([columns, integral[:, None], drift])
    white = solve_triangular(factor, right, lower=True, check_finite=False)
    n = columns.shape[1]
    regressors, value, spread = white[:, :n], white[:, n], white[:, n + 1 :].real
    basis, triangle = np.linalg.qr(regressors)
    parts = np.linalg.solve(triangle, basis.conj().T @ value)
    rest = value - regressors @ parts
    position: ComplexArray = integral - columns @ parts - spread.T @ rest
    unknown = solve_triangular(triangle.T, (columns - spread.T @ regressors).T, lower=True, check_finite=False)
    variance = np.diag(drift) - (spread**2).sum(0) + (np.abs(unknown) ** 2).sum(0)
    likelihood = -2.0 * (np.log(np.diag(factor)).sum() + np.log(np.abs(np.diag(triangle))).sum())
    likelihood -= 0.5 * float((np.abs(rest) ** 2).sum())
    return _Motion(float(likelihood), position, np.sqrt(np.maximum(variance, 0.0)))


def _drift(time: Array, interval: float, noise: ToolNoise) -> Array:
    """Covariance of the position on an axis by the noise since the start [m^2].

    The covariance adds the second integral of the accelerometers' noise, and the third integral of the gyroscopes'
    noise times gravity.
    """
    low, high = np.minimum.outer(time, time), np.maximum.outer(time, time)
    force = low**2 * (3.0 * high - low) / 6.0  # integral of (low - t) (high - t)
    tilt = low**3 * (10.0 * high**2 - 5.0 * high * low + low**2) / 120.0  # integral of their squares over 4
    return np.asarray(interval * (noise.force**2 * force + (GRAVITY * noise.rate) ** 2 * tilt))


def _twice(acceleration: ComplexArray) -> ComplexArray:
    """Integral of the integral of means over intervals, at their ends, in units of the interval squared."""
    return np.asarray(np.cumsum(np.cumsum(acceleration) - 0.5 * acceleration))


def _running_mean(values: Array, width: int) -> Array:
    """Mean over a window about each value, shorter at the ends."""
    window = np.ones(width)
    return np.asarray(np.convolve(values, window, "same") / np.convolve(np.ones(values.size), window, "same"))


def _first_crossing(radius: Array, revolutions: Array, sustain: float) -> float | None:
    """First time [rev] from which a radius is above 1 for `sustain` [rev], or to the end; None if never."""
    above = np.concatenate([[False], radius > 1.0, [False]])
    edges = np.flatnonzero(np.diff(above.astype(np.int8)))
    for begin, end in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        if end == radius.size - 1 or revolutions[end] - revolutions[begin] >= sustain:
            before = max(begin - 1, 0)
            low, high = float(radius[before]), float(radius[begin])
            fraction = (1.0 - low) / (high - low) if high > 1.0 > low else 1.0
            return float(revolutions[begin] - (1.0 - fraction) * (revolutions[begin] - revolutions[before]))
    return None
