# SPDX-License-Identifier: Apache-2.0
"""Errors of instruments: noise and bias from a seed, range, resolution.

The noise of a sample depends on the seed, the instrument and the number of the sample only, so a run that is resumed
reads as one that was not interrupted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.scene.blocks.sensors import Channel

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
