# SPDX-License-Identifier: Apache-2.0
"""Likelihood of a record under runs: of the time series, or of features of windows."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy import special

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError
from drill_twin_studies.goodness import BAND, Goodness, noise_of

FLOOR = 0.01
"""Least error of model and sensor together, over the standard deviation of the record."""
_LEAST = 1e-77
"""Least error of a sample, of a record that is constant; its square is not 0."""
FEWEST_WINDOWS = 3
"""Windows of a record from which their scatter can be told; with two, limits of what chance explains are endless."""
OVERLAP = 4
"""Windows that begin in the length of one: more tell little more (Welch 1967)."""

Channels = Mapping[str, Array]
"""Values by channel: of the record of shape (T,), of M runs of shape (M, T)."""


def of_series(record: Channels, runs: Channels, free: int) -> Array:
    """Logarithm of the likelihood of the time series of each run, shape (M,); Gaussian errors of `error_variance`.

    Samples that are missing in the record (NaN) are left out. The run that fits best tells what the model leaves.

    Args:
        record: The record.
        runs: The runs.
        free: Number of free numbers.
    """
    squares: dict[str, Array] = {}
    total = result = np.zeros(len(next(iter(runs.values()))))
    for channel, values in runs.items():
        known = np.isfinite(record[channel])
        if known.any():
            squares[channel] = np.mean((values[:, known] - record[channel][known]) ** 2, axis=1)
            total = total + squares[channel] / noise_in(record[channel], record[channel]) ** 2
    best = int(np.argmin(np.where(np.isfinite(total), total, np.inf)))
    for channel, square in squares.items():
        noise = noise_in(record[channel], record[channel] - runs[channel][best]) ** 2
        count = int(np.isfinite(record[channel]).sum())
        result = result - 0.5 * count * square / error_variance(float(square[best]), noise, count, free)
    return result


def noise_in(record: Array, residual: Array) -> float:
    """Standard deviation of the errors of the samples of a record: noise, and `FLOOR` for the model's rounding.

    Noise is told from the record or from what a run leaves of it, whichever has less noise: jerks of a motion that
    sticks and slips count as noise of the record, but a run takes them away.
    """
    known = record[np.isfinite(record)]
    floor = FLOOR * float(np.std(known)) if known.size else 0.0
    return max(math.hypot(min(noise_of(record), noise_of(residual)), floor), _LEAST)


def error_variance(square: float, noise: float, count: int, free: int) -> float:
    """Variance of the error of a sample: of its noise, and of what the model leaves unexplained.

    Where the residual is no larger than the noise, there is noise alone. What exceeds the noise is an error of the
    model. A part of the error does not show, as the free numbers have taken it up. This part is assumed to be as large
    as the part that shows: so the error of the model counts as `free` independent samples and not as `count`. Chance
    makes every other residual of a right model exceed its noise a little: its bands are wider.

    Args:
        square: Mean square of the residual of the best run.
        noise: Variance of the noise.
        count: Number of samples.
        free: Number of free numbers.
    """
    plain = max(square * count / max(count - free, 1), noise)
    shown = max(square / noise - 1.0, 0.0)
    return plain * (1.0 + shown * max(1.0, count / free))


def of_features(record: Channels, runs: Channels, period: float, window: float) -> Array:
    """Logarithm of the likelihood of the mean features of windows of each run, shape (M,).

    For motion whose phase is not determined. The covariance is known from as few windows as there are: the likelihood
    follows Student's t (Sellentin and Heavens 2016).

    Args:
        record: The record.
        runs: The runs.
        period: Time from sample to sample [s].
        window: Length of a window [s].

    Raises:
        ArgumentError: The record has fewer windows without a gap than tell how they scatter.
    """
    seen = WindowedRecord(record, period, window)
    result = np.full(len(next(iter(runs.values()))), -np.inf)
    for m in range(result.size):
        if all(np.isfinite(values[m]).all() for values in runs.values()):
            found = seen.less({channel: values[m] for channel, values in runs.items()})
            size = np.linalg.slogdet(found.covariance)[1]
            result[m] = -0.5 * (size + (found.freedom + 1.0) * math.log1p(found.square / found.freedom))
    return result


class Difference(NamedTuple):
    """Mean features of a record less a run's features, shape (F,), and their scatter by chance."""

    mean: Array
    covariance: Array
    """Covariance of the difference, shape (F, F)."""
    freedom: float
    """Degrees of freedom with which the covariance is known."""
    square: float
    """Square of the difference over its covariance."""


class WindowedRecord:
    """Features of the windows of a record, with which runs are compared.

    Windows overlap, so that few of them have all phases of the motion; the covariance of their mean is known as from
    half as many more windows that do not (Meketon and Schmeiser 1984). A run gets the noise that the record has more.
    """

    def __init__(self, record: Channels, period: float, window: float) -> None:
        """Take a record, shape (T,) by channel.

        Raises:
            ArgumentError: The record has fewer windows without a gap than tell how they scatter.
        """
        self._period = period
        self._length = OVERLAP * max(2, round(window / period / OVERLAP))
        self._noise = {channel: noise_of(values) for channel, values in record.items()}
        found = np.concatenate([features(values, period, self._length) for values in record.values()], axis=1)
        self._features = found[np.isfinite(found).all(axis=1)]
        self.windows = max(0.0, 1.0 + (len(self._features) - 1) / OVERLAP)
        """Number of windows side by side."""
        if self.windows < FEWEST_WINDOWS - 1.0 / OVERLAP:  # a sample may be wanting at each end
            raise ArgumentError(
                f"fit: expected {FEWEST_WINDOWS} windows of features or more without a gap, found {self.windows:.3g} "
                f"of {self._length * period:g} s; take a shorter --window (a period of the motion or more), or a "
                "longer record"
            )
        least = [max(FLOOR * float(np.nanstd(values)), _LEAST) for values in record.values()]
        self._floor = np.square([(one, FLOOR, one, one, 0.0) for one in least]).ravel()
        whole = (2.0 * self._length * period) ** -2 / 6.0  # of counts: a part f of one has the variance f (1 - f)
        self._counted = np.tile((0.0, 0.0, 0.0, 0.0, whole), len(record))
        self._scatter = self._of_mean(self._features)

    def less(self, run: Channels) -> Difference:
        """The record less a run, shape (T,) by channel."""
        generator, parts = np.random.default_rng(0), []
        for channel, noise in self._noise.items():
            more = math.sqrt(max(noise**2 - noise_of(run[channel]) ** 2, 0.0))
            noisy = run[channel] + more * generator.standard_normal(run[channel].size)
            parts.append(features(noisy, self._period, self._length))
        computed = np.concatenate(parts, axis=1)
        freedom = 1.5 * (self.windows - 1.0 + (len(computed) - 1) / OVERLAP)
        covariance = _shrunk(self._scatter + self._of_mean(computed) + np.diag(self._floor), freedom)
        mean = self._features.mean(axis=0) - computed.mean(axis=0)
        return Difference(mean, covariance, freedom, float(mean @ np.linalg.solve(covariance, mean)))

    def _of_mean(self, found: Array) -> Array:
        """Covariance of the mean of features, shape (windows, F)."""
        return np.asarray((np.cov(found.T) + np.diag(self._counted)) / (1.0 + (len(found) - 1) / OVERLAP))


def features_goodness(record: Channels, run: Channels, period: float, window: float) -> dict[str, Goodness]:
    """Goodness of a run by channel: its mean features against their scatter, whatever the phase.

    One of 100 runs with the right numbers exceeds the limit (F distribution); the best run lies closer than that.
    """
    found = {}
    for channel, measured in record.items():
        seen = WindowedRecord({channel: measured}, period, window)
        one = seen.less({channel: run[channel]})
        count, over = one.mean.size, np.abs(one.mean) / np.sqrt(np.diag(one.covariance))
        found[channel] = Goodness(
            samples=int(seen.windows), residual=float(np.sqrt(np.mean(over**2))), noise=1.0, correlation=math.nan,
            independent=seen.windows, chi_square=one.square / count,
            inside=float(np.mean(over <= special.stdtrit(one.freedom, 0.5 + 0.5 * BAND))),
            limit=float(special.fdtri(count, one.freedom, 0.99)), of="features", against="their scatter",
        )  # fmt: skip
    return found


def features(values: Array, period: float, length: int) -> Array:
    """Features of windows of so many samples, `OVERLAP` of which begin in one, shape (windows, 5), of a series (T,).

    Mean, logarithm of the standard deviation, 5 and 95 % quantiles, and half of the crossings of the mean per second.
    """
    if values.size < length:
        return np.zeros((0, 5))
    parts = np.lib.stride_tricks.sliding_window_view(values, length)[:: length // OVERLAP]
    centred = parts - parts.mean(axis=1, keepdims=True)
    crossings = np.sum(np.diff(np.signbit(centred), axis=1), axis=1) / (2.0 * length * period)
    low, high = np.quantile(parts, (0.05, 0.95), axis=1)
    return np.stack((parts.mean(axis=1), np.log(parts.std(axis=1) + _LEAST), low, high, crossings), axis=1)


def _shrunk(covariance: Array, freedom: float) -> Array:
    """Covariance, shrunk towards its diagonal as Gaussian samples need it (Chen, Wiesel, Eldar and Hero 2010).

    Their estimate (23) of the correlation; Ledoit and Wolf's (2004) needs more samples than there are windows.
    """
    size = np.sqrt(np.diag(covariance))
    correlation, count = covariance / np.outer(size, size), size.size
    square = float(np.sum(correlation**2))
    above = (1.0 - 2.0 / count) * square + count**2
    below = (freedom + 1.0 - 2.0 / count) * max(square - count, 1e-9)
    share = min(1.0, above / below)
    return np.asarray(covariance * ((1.0 - share) + share * np.eye(count)))
