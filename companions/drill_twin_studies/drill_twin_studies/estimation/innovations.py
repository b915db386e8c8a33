# SPDX-License-Identifier: Apache-2.0
"""Innovations, measured less predicted, of the last windows, and the errors of channels that they show."""

import math
from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_studies.estimation.square_root_filter import correction
from drill_twin_studies.goodness import Goodness, goodness, noise_of

_MEMORY = 10.0
"""Windows over which a raised error fades; not measured."""
_GATE = 8.0
"""Standard deviations from which a sample is absurd, if most samples of its channel are not; not measured."""


class ChannelErrors:
    """Standard deviations of C channels.

    Attributes:
        scale: Largest size of each channel so far [SI], shape (C,).
        absurd: Samples that were left out so far.
    """

    def __init__(self, channels: int, share: float, floor: Array | float = 0.0) -> None:
        """Begin.

        Args:
            channels: Number of the channels.
            share: Error of sensor and model together, as a share of the channel's scale.
            floor: Least error of a sample, of a noise that is known, shape (C,).
        """
        self._share = share
        self.scale: Array = np.zeros(channels)
        self._raised: Array = np.zeros(channels)
        self._least: Array = np.maximum(floor, np.full(channels, np.finfo(float).tiny ** 0.25))
        self.absurd = 0

    @property
    def stated(self) -> Array:
        """Standard deviation that is stated for the error of a sample of each channel, shape (C,)."""
        return np.maximum(self._share * self.scale, self._least)

    @property
    def deviation(self) -> Array:
        """Standard deviation of the error of a sample, with what innovations have shown, shape (C,)."""
        return np.maximum(np.sqrt(self._raised), self.stated)

    def forget(self) -> None:
        """Forget what the innovations of a jump have shown."""
        self._raised[:] = 0.0

    def screen(self, predicted: Array, measured: Array) -> Array:
        """Measured samples; NaN for a sample that is absurd beside the others of its channel.

        Args:
            predicted: Channels of N members, shape (N, C, S).
            measured: Channels of the rig, shape (C, S).
        """
        with np.errstate(invalid="ignore"):
            self.scale = np.fmax(self.scale, np.abs(predicted).max(axis=(0, 2)))
            width = np.sqrt(predicted.var(axis=0, ddof=1) + self.deviation[:, None] ** 2)
            off = np.abs(measured - predicted.mean(axis=0)) > _GATE * width
        known = np.isfinite(measured).sum(axis=1)
        few = off.sum(axis=1) < 0.5 * np.maximum(known, 1)
        off &= few[:, None]
        self.absurd += int(off.sum())
        return np.where(off, np.nan, measured)

    def learn(self, measured: Array, before: Array, after: Array) -> None:
        """Raise the errors that the innovations show (Desroziers, Berre, Chapnik and Poli 2005, Eq. 1).

        Args:
            measured: Channels of the rig, shape (C, S); NaN where missing.
            before: Mean of the members before the correction, shape (C, S).
            after: Mean of the members after it, shape (C, S).
        """
        product = np.where(np.isfinite(measured), (measured - after) * (measured - before), 0.0)
        found = product.sum(axis=1) / np.maximum(np.isfinite(measured).sum(axis=1), 1)
        self._raised = np.maximum(self._raised + (found - self._raised) / _MEMORY, 0.0)


LIMIT = 3.0
"""Rms innovation of a window over the predicted one, from which the window is not explained. The samples of a window
may err alike: then the ratio is the size of one normal value, which is larger in 0.3 % of the windows of a right
model."""


WINDOWS = 20
"""Windows that are judged together; not measured."""
_FEWEST = 10
"""Windows from which a change of the mean innovation can be told; half of the samples that tell their noise."""
_LEAST_NOISE = 0.25
"""Noise of a channel over its stated error, at least: sensor and model err together as the stated error says, and the
record of a twin has no noise."""


class Innovations:
    """Innovations of C channels over the last `WINDOWS`.

    Attributes:
        misfit: Rms innovation of the last window over the channel's scale, shape (C,); NaN where nothing was measured.
        normalised: Rms innovation of the last window over what members and stated errors predict for it, shape (C,).
        off: Rms innovation of the last window [SI], shape (C,).
        surprises: Squared innovation of the last window over its covariance, from members and noise, shape (C,).
        samples: Number of samples of the last window, shape (C,).
    """

    def __init__(self, channels: Sequence[str], few: float = 1.0) -> None:
        """Begin.

        Args:
            channels: Names.
            few: Factor by which the spread of the members may be too small, where a misfit is judged.
        """
        self._channels, self._few = list(channels), few
        self._windows: deque[Array] = deque(maxlen=WINDOWS)  # measured, predicted mean and spread, shape (3, C, S)
        self._stated: Array = np.zeros(len(channels))
        self.misfit: Array = np.full(len(channels), np.nan)
        self.normalised, self.off = self.misfit.copy(), self.misfit.copy()
        self.surprises: Array = np.zeros(len(channels))
        self.samples: Array = np.zeros(len(channels))

    def take(self, predicted: Array, measured: Array, scale: Array, stated: Array) -> None:
        """Take a window.

        Args:
            predicted: Channels of the members before the correction, shape (N, C, S).
            measured: Channels, shape (C, S); NaN where missing.
            scale: Largest size of each channel [SI], shape (C,).
            stated: Standard deviation that is stated for the error of a sample [SI], shape (C,).
        """
        mean, spread = predicted.mean(axis=0), predicted.std(axis=0, ddof=1)
        self._windows.append(np.stack((measured, mean, spread)))
        self._stated = stated
        square = (measured - mean) ** 2
        self.off = rms(square)
        self.misfit = self.off / np.maximum(scale, np.finfo(float).tiny ** 0.25)
        self.normalised = rms(square / ((self._few * spread) ** 2 + stated[:, None] ** 2))
        noise = self._noise()
        self.samples = np.where(np.isfinite(noise), np.isfinite(measured).sum(axis=1), 0)
        wide = mean + self._few * (predicted - mean)
        self.surprises = np.array([_surprise(wide[:, k], row, noise[k]) for k, row in enumerate(measured)])

    def _noise(self) -> Array:
        """Noise of each channel over the last windows, shape (C,); NaN where the samples are too few to tell it."""
        found = np.full(len(self._channels), np.nan)
        for k, row in enumerate(np.concatenate([each[0] for each in self._windows], axis=1)):
            known = row[np.isfinite(row)]
            if known.size >= 2 * _FEWEST:
                found[k] = max(noise_of(row) or noise_of(known), _LEAST_NOISE * self._stated[k])
        return found

    def forget(self) -> None:
        """Forget all windows: numbers have jumped, and are drawn anew."""
        last = self._windows[-1]
        last[0] = np.nan
        self._windows = deque([last], maxlen=WINDOWS)

    def judged(self) -> Mapping[str, Goodness]:
        """Goodness of each channel over the last windows, against the stated errors."""
        measured, mean, spread = np.concatenate(list(self._windows), axis=2)
        return {
            name: goodness(measured[k], mean[k], spread[k], noise_of(measured[k]), float(self._stated[k]), math.nan)
            for k, name in enumerate(self._channels)
        }


def widening(found: Mapping[str, Goodness]) -> float:
    """Factor of the bands of what is not measured: root of the largest chi-square of a channel where that exceeds 1.

    What is not measured is taken to err as the measured channels do. The bands are widened, and not the ensemble, which
    the inflation of Anderson (2009) widens.
    """
    return math.sqrt(max([1.0, *(one.chi_square for one in found.values() if one.samples)]))


def widening_of_numbers(found: Mapping[str, Goodness]) -> float:
    """Factor of the bands of numbers: as `widening`, with chi-square times the samples for each independent one.

    The filter learns from each sample as from a new one; where the model errs alike from sample to sample, the mean of
    many has the error of the independent ones alone.
    """
    known = (one for one in found.values() if one.samples and one.independent > 0.0)
    return math.sqrt(max([1.0, *(one.chi_square * one.samples / one.independent for one in known)]))


def _surprise(predicted: Array, measured: Array, noise: float) -> float:
    """Squared innovation over its covariance, of members (N, S), samples (S,) and noise; their number, if it is right.

    A covariance of few members is too small in the q directions in which they differ: there the expected square is
    q (N + 1) / N (N - 1) / (N - q - 2) (Hotelling 1931), by which it is divided. 0 where nothing can be told.
    """
    count, known = len(predicted), int(np.isfinite(measured).sum())
    if not known or not math.isfinite(noise):
        return 0.0
    found = correction(predicted, measured, np.full(measured.size, noise**2))
    along, left = found.directions, count - found.directions - 2.0
    if left <= 0.0:
        return 0.0
    return found.surprise * known / (known - along + along * (count + 1) / count * (count - 1) / left)


def rms(squares: Array) -> Array:
    """Root of the mean of the finite squares, shape (C,), of shape (C, S); NaN where there is none."""
    known = np.isfinite(squares)
    count = known.sum(axis=1)
    total = np.where(known, squares, 0.0).sum(axis=1)
    return np.where(count > 0, np.sqrt(total / np.maximum(count, 1)), np.nan)
