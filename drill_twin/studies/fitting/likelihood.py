# SPDX-License-Identifier: Apache-2.0
"""Likelihood of a record under runs: of the time series, or of features of windows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.studies.goodness import noise_of

FLOOR = 0.01
"""Least error of model and sensor together, over the standard deviation of the record."""
_LEAST = 1e-77
"""Least error of a sample, of a record that is constant; its square is not 0."""
_SHRINKAGE = 0.3

Channels = Mapping[str, Array]
"""Values by channel: of the record of shape (T,), of M runs of shape (M, T)."""


def of_series(record: Channels, runs: Channels, period: float, window: float, free: int = 1) -> Array:
    """Logarithm of the likelihood of the time series of each run, shape (M,); Gaussian errors of `error_variance`.

    Samples that are missing in the record (NaN) are left out. The run that fits best tells what the model leaves.

    Args:
        record: The record.
        runs: The runs.
        period: Time from sample to sample [s]; unused.
        window: Unused.
        free: Number of free numbers.
    """
    del period, window
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

    Noise is told from the record or from what a run leaves of it, whichever has less of it: what is not smooth in a
    motion that sticks and slips counts as noise of the record, but a run takes it away.
    """
    known = record[np.isfinite(record)]
    floor = FLOOR * float(np.std(known)) if known.size else 0.0
    return max(math.hypot(min(noise_of(record), noise_of(residual)), floor), _LEAST)


def error_variance(square: float, noise: float, count: int, free: int) -> float:
    """Variance of the error of a sample: of its noise, and of what the model leaves unexplained.

    Where the residual is no larger than the noise, that is all. What exceeds the noise is an error of the model. A part
    of that error does not show, as the free numbers have taken it up; it is assumed to be as large as the one that
    shows, and to be shared by them: so the error of the model counts as `free` independent samples and not as `count`.
    Chance makes every other residual of a right model exceed its noise a little: its bands are wider.

    Args:
        square: Mean square of the residual of the best run.
        noise: Variance of the noise.
        count: Number of samples.
        free: Number of free numbers.
    """
    plain = max(square * count / max(count - free, 1), noise)
    shown = max(square / noise - 1.0, 0.0)
    return plain * (1.0 + shown * max(1.0, count / free))


def of_features(record: Channels, runs: Channels, period: float, window: float, free: int = 1) -> Array:
    """Logarithm of the likelihood of the mean features of windows of each run, shape (M,).

    For motion whose phase is not determined. Windows scatter; the covariance of a mean is that of the windows of
    record and run over their number, shrunk towards its diagonal (Ledoit and Wolf 2004), as windows are few.

    Args:
        record: The record.
        runs: The runs.
        period: Time from sample to sample [s].
        window: Length of a window [s].
        free: Unused.
    """
    del free
    seen = np.concatenate([features(values[None], period, window) for values in record.values()], axis=2)[0]
    seen = seen[np.isfinite(seen).all(axis=1)]  # windows with a gap
    computed = np.concatenate([features(runs[channel], period, window) for channel in record], axis=2)
    result = np.full(len(computed), -np.inf)
    for m, of_run in enumerate(computed):
        if not np.isfinite(of_run).all():
            continue
        covariance = (_covariance(seen) + _covariance(of_run)) / len(seen)
        difference = seen.mean(axis=0) - of_run.mean(axis=0)
        _, size = np.linalg.slogdet(covariance)
        result[m] = -0.5 * (size + difference @ np.linalg.solve(covariance, difference))
    return result


LIKELIHOODS: Mapping[str, Callable[[Channels, Channels, float, float, int], Array]] = {
    "series": of_series,
    "features": of_features,
}
"""Likelihoods by name."""


def features(values: Array, period: float, window: float) -> Array:
    """Features of windows that follow one another, shape (M, windows, 5), of values of shape (M, T).

    Mean, logarithm of the standard deviation, 5 and 95 % quantiles, crossings of the mean.
    """
    length = max(8, round(window / period))
    count = max(1, values.shape[1] // length)
    parts = values[:, : count * length].reshape(len(values), count, -1)
    centred = parts - parts.mean(axis=2, keepdims=True)
    crossings = np.sum(np.diff(np.signbit(centred), axis=2), axis=2) / (2.0 * length * period)
    low, high = np.quantile(parts, (0.05, 0.95), axis=2)
    deviation = np.log(parts.std(axis=2) + 1e-12)
    return np.stack((parts.mean(axis=2), deviation, low, high, crossings), axis=2)


def _covariance(windows: Array) -> Array:
    """Covariance of windows, shape (windows, F), shrunk towards its diagonal."""
    spread = windows - windows.mean(axis=0)
    found: Array = spread.T @ spread / max(1, len(windows) - 1)
    floor = (1e-3 * (np.abs(windows).mean(axis=0) + 1e-9)) ** 2
    return (1.0 - _SHRINKAGE) * found + np.diag(_SHRINKAGE * np.diag(found) + floor)
