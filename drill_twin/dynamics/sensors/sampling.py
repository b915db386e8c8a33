# SPDX-License-Identifier: Apache-2.0
"""Sampling at the rate of an instrument: means since the last sample, with errors and delay; the surface channels.

The errors are noise and bias from a seed, range and resolution. The noise of a sample depends on the seed, the
instrument and the number of the sample only, so a resumed run has the readings of an uninterrupted run.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Channel, Surface

_BLOCK = 256  # samples drawn at once


class InstrumentErrors(NamedTuple):
    """Errors of c quantities that an instrument measures, each of shape (c,)."""

    noise: Array
    """Standard deviation of a sample."""
    bias: Array
    """Constant offset."""
    largest: Array
    """Largest reading of either sign; infinite without a limit."""
    step: Array
    """Step of the readings; 0 without quantisation."""


def errors_of(channels: Sequence[Channel], seed: int, instrument: int) -> InstrumentErrors:
    """Errors of the channels of an instrument, with a bias drawn from its seed; one channel for each quantity."""
    draw = np.random.default_rng([seed, instrument, 0]).normal(size=len(channels))
    noise, spread, largest, step = np.array([(c.noise, c.bias, c.range or np.inf, c.resolution) for c in channels]).T
    return InstrumentErrors(noise, spread * draw, largest, step)


def with_errors(true: Array, normal: Array, errors: InstrumentErrors) -> Array:
    """Readings of true values, shape (..., c).

    Args:
        true: True values, shape (..., c).
        normal: Standard normal numbers, shape (..., c).
        errors: The errors.
    """
    reading = true + errors.bias + errors.noise * normal
    step = np.where(errors.step > 0.0, errors.step, 1.0)
    reading = np.where(errors.step > 0.0, np.round(reading / step) * step, reading)
    return np.clip(reading, -errors.largest, errors.largest)


class ReadingNoise:
    """Standard normal numbers by the number of the sample."""

    def __init__(self, channels: int, seed: int, instrument: int) -> None:
        self._channels, self._key = channels, [seed, instrument, 1]
        self._block, self._values = -1, np.empty((0, channels))

    def at(self, sample: int) -> Array:
        """Numbers of a sample, shape (channels,)."""
        block, row = divmod(sample, _BLOCK)
        if block != self._block:
            self._block = block
            self._values = np.random.default_rng([*self._key, block]).normal(size=(_BLOCK, self._channels))
        return np.asarray(self._values[row])


_SLACK = 1e-6  # of a sample: frames are due at whole multiples of the rate, but for round-off


class Reading(NamedTuple):
    """Reading of an instrument."""

    time: float
    """Time of the measurement, the middle of the interval that it covers [s]."""
    values: Array
    """Measured values."""


class Instrument:
    """Samples values at its own rate, and gives readings after its delay."""

    def __init__(self, channels: Sequence[Channel], rate: float, delay: float, seed: int, number: int) -> None:
        """Draw the biases.

        Args:
            channels: Errors of each value.
            rate: Samples in a second [Hz].
            delay: Time from the measurement to its reading [s].
            seed: Seed of the scene.
            number: Number of the instrument, for noise of its own.
        """
        self._errors = errors_of(channels, seed, number)
        self._noise = ReadingNoise(len(channels), seed, number)
        self._rate, self._delay = rate, delay
        self._sum, self._covered = np.zeros(len(channels)), 0.0
        self._waiting = deque[Reading]()

    def advance(self, time: float, seconds: float, true: Array) -> list[Reading]:
        """Advance to a time [s]; return the readings whose delay is over then.

        Args:
            time: End of the interval [s].
            seconds: Length of the interval [s].
            true: Means of the true values over the interval.
        """
        self._sum += seconds * true
        self._covered += seconds
        number = math.floor(time * self._rate + _SLACK)
        if number > math.floor((time - seconds) * self._rate + _SLACK):
            values = with_errors(self._sum / self._covered, self._noise.at(number), self._errors)
            self._waiting.append(Reading(time - 0.5 * self._covered, values))
            self._sum[:], self._covered = 0.0, 0.0
        due = []
        while self._waiting and self._waiting[0].time + self._delay <= time + _SLACK / self._rate:
            due.append(self._waiting.popleft())
        return due


_SURFACE = 1_000_000  # number of the instrument for its noise, beyond the numbers of the subs


class SurfaceValues(NamedTuple):
    """Measurements of a rig at the surface; numbers, or arrays of one shape."""

    speed: float | Array
    """Speed of the top drive [rad/s]."""
    torque: float | Array
    """Torque of the drive [N m]."""
    hookload: float | Array
    """Hookload [N]."""
    block_position: float | Array
    """Height of the travelling block above its start [m]."""


class SurfaceSampler:
    """Samples the surface channels of a scene."""

    def __init__(self, scene: Scene, surface: Surface, time: float, speed: float) -> None:
        """Begin at a time [s] and speed of the drive [rad/s]."""
        drive = scene.rig.top_drive
        self._inertia = drive.inertia if surface.drive_inertia is None else surface.drive_inertia
        self._damping = drive.damping
        self._time, self._speed = time, speed
        channels = (surface.speed, surface.torque, surface.hookload, surface.block_position)
        self._instrument = Instrument(channels, surface.rate, surface.delay, scene.numerics.seed, _SURFACE)

    def advance(self, time: float, found: SurfaceValues) -> list[Reading]:
        """Advance to a time [s]; return the readings that are due, in the order of `SurfaceValues`.

        Args:
            time: End of the frame [s].
            found: True values, with the torque on the string.
        """
        seconds = time - self._time
        turned = (found.speed - self._speed) / seconds
        torque = found.torque + self._inertia * turned + self._damping * found.speed
        self._time, self._speed = time, float(found.speed)
        return self._instrument.advance(time, seconds, np.array(found._replace(torque=torque)))
