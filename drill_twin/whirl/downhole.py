# SPDX-License-Identifier: Apache-2.0
"""Whirl from the readings of one downhole sub: lateral motion of its section, and the analysis of it as of a mark.

Gyroscopes give attitude and spin. The lateral specific force, turned back by the spin, is the acceleration of the
centre line, plus the lever arm of the sensor (r Omega^2, r dOmega/dt) and gravity by the tilt of the section; both are
removed. What then is constant or drifts slowly in the frame of the hole (gravity in an inclined hole, turned by a bias
of the gyroscope) or is constant in that of the string (bias, bow) is fitted over the first revolutions and removed. A
Butterworth high pass of fourth order, integrated twice, gives the position about its mean, for whirls well above the
corner.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.analyzer import Analyzer
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.findings import Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo

GRAVITY = 9.81
"""Gravity that tilt turns into lateral force, in the estimate of the noise [m/s^2]."""
SLOWEST = 0.06
"""Least corner of the high pass over the rotation [-]."""
CALIBRATION = 4.0
"""Length of the record over which constants are fitted [rev]."""
TURNING = 0.9
"""The record is used from this share of the usual speed on [-]."""
_NOISE_GAIN = 1.0 / (8.0 * math.sin(3.0 * math.pi / 8.0))  # of x^4 / (1 + x^8) over all x, by 2 pi
_DAMPING = math.cos(math.pi / 8.0), math.cos(3.0 * math.pi / 8.0)


class ToolNoise(NamedTuple):
    """Noise of the instruments of a sub: standard deviation of a sample."""

    force: float
    """Of the accelerometers [m/s^2]."""
    rate: float
    """Of the gyroscopes [rad/s]."""


class LateralMotion(NamedTuple):
    """Lateral motion of a section about its mean, T samples."""

    stamp: NDArray[np.int64]
    """Stamps [ns], shape (T,)."""
    position: ComplexArray
    """x + i y of the centre line [m], shape (T,); x where the sensor pointed at first."""
    spin: Array
    """Spin since the first reading [rad], shape (T,)."""
    speed: Array
    """Speed of rotation [rad/s], shape (T,)."""
    corner: float
    """Corner of the high pass [rad/s]: slower whirls are not seen."""


def corner_for(clearance: float, noise: ToolNoise, interval: float) -> float:
    """Lowest corner at which the noise of the position stays below the threshold of an onset [rad/s].

    The variance of the position is k S_f / a^3 + k g^2 S_w / a^5 on each axis, with S = sigma^2 T of accelerometers and
    gyroscopes, the corner a and k = 1 / (8 sin(3 pi / 8)): the integrals of the spectra behind the high pass.

    Args:
        clearance: Lateral clearance of the section [m].
        noise: Noise of the instruments.
        interval: Time between samples T [s].
    """
    criteria = Criteria()
    allowed = (criteria.onset_radius * clearance / criteria.false_alarm_factor) ** 2
    force, tilt = (_NOISE_GAIN * interval * part**2 / allowed for part in (noise.force, GRAVITY * noise.rate))
    roots = np.roots([1.0, 0.0, 0.0, -force, 0.0, -tilt])  # one is positive (Descartes)
    return float(max(roots.real[np.abs(roots.imag) <= 1e-9 * np.abs(roots)]))


def lateral_motion(stamp: NDArray[np.int64], readings: Array, radius: float, corner: float = 0.0) -> LateralMotion:
    """Lateral motion of the section of a sub, from the time on at which it turns.

    Args:
        stamp: Stamps of the readings, the middle of what each covers [ns], shape (n,).
        readings: Specific force [m/s^2] and rates [rad/s] in the axes of the sub, shape (n, 6).
        radius: Distance of the sensor from the axis of the collar [m].
        corner: Least corner of the high pass [rad/s]; `SLOWEST` of the rotation where that is more.

    Raises:
        AnalysisError: The readings are not evenly spaced, do not turn, or are too few.
    """
    intervals = np.diff(stamp)
    if len(stamp) < 2 or np.ptp(intervals) > 0.01 * intervals.mean():
        found = f"intervals of {intervals.min() * 1e-9:g} to {intervals.max() * 1e-9:g} s" if len(intervals) else "none"
        raise AnalysisError(f"expected readings at a steady rate, found {found}")
    interval, speed = float(intervals.mean()) * 1e-9, readings[:, 5]
    usual = float(np.median(np.abs(speed[len(speed) // 2 :])))
    spin = np.cumsum(speed) * interval
    revolutions = np.cumsum(np.abs(speed)) * interval / math.tau
    start = int(np.argmax(np.abs(speed) >= TURNING * usual))
    begin = int(np.searchsorted(revolutions, revolutions[start] + CALIBRATION))
    if usual < math.tau * Criteria().rest_rotation or begin >= len(stamp) - 1:
        raise AnalysisError(f"expected more than {CALIBRATION:g} revolutions of a sub, found {revolutions[-1]:.2f}")
    turn = np.exp(1j * (spin - 0.5 * speed * interval))  # of the middle of each interval
    rest = _acceleration(readings, turn, radius, interval)
    constants = np.stack([np.ones_like(turn), revolutions + 0j, turn], -1)
    rest = rest - constants @ np.linalg.lstsq(constants[start:begin], rest[start:begin], rcond=None)[0]
    rest[:begin] = 0.0
    chosen = max(corner, SLOWEST * usual)
    position = _integrated(rest, chosen, interval)
    ends = stamp + round(0.5e9 * interval)
    return LateralMotion(ends[begin:], position[begin:], spin[begin:], speed[begin:], chosen)


def analyse_sub(stamp: NDArray[np.int64], readings: Array, mark: MarkInfo, radius: float, noise: ToolNoise) -> Summary:
    """Findings of the whirl analysis for the section of a sub.

    Args:
        stamp: Stamps of the readings [ns], shape (n,).
        readings: Specific force [m/s^2] and rates [rad/s] in the axes of the sub, shape (n, 6).
        mark: The section, as a mark on the centre.
        radius: Distance of the sensor from the axis of the collar [m].
        noise: Noise of the instruments.

    Raises:
        AnalysisError: As `lateral_motion`.
    """
    interval = float(np.mean(np.diff(stamp))) * 1e-9 if len(stamp) > 1 else 1.0
    motion = lateral_motion(stamp, readings, radius, corner_for(mark.clearance, noise, interval))
    analyzer = Analyzer([mark])
    place = np.stack([motion.position.real, motion.position.imag], -1)[:, None]
    analyzer.push_block(motion.stamp, place, motion.spin[:, None], motion.speed)
    return analyzer.summary()


def _acceleration(readings: Array, turn: ComplexArray, radius: float, interval: float) -> ComplexArray:
    """Lateral acceleration of the centre line in the frame of the hole, and constants [m/s^2], shape (n,)."""
    force, speed = readings[:, 0] + 1j * readings[:, 1], readings[:, 5]
    arm = radius * (1j * np.gradient(speed, interval) - speed**2)
    swing = -1j * (readings[:, 3] + 1j * readings[:, 4]) * turn  # rate of the tangent
    tilt = (np.cumsum(swing) - 0.5 * swing) * interval
    acceleration: ComplexArray = (force - arm) * turn + np.median(readings[:, 2]) * tilt
    return acceleration


def _integrated(acceleration: ComplexArray, corner: float, interval: float) -> ComplexArray:
    """Integral of the integral of means over intervals, at their ends, behind the high pass."""
    from scipy.signal import cont2discrete, lfilter

    low, high = ([1.0, 2.0 * damping * corner, corner**2] for damping in _DAMPING)
    numerator, denominator, _ = cont2discrete(([1.0, 0.0, 0.0], np.polymul(low, high)), interval, "zoh")
    position: ComplexArray = lfilter(numerator.ravel(), denominator, acceleration)
    return position
