# SPDX-License-Identifier: Apache-2.0
"""Likelihood of a record under runs: of the time series, or of features of windows."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from drill_twin.core.arrays import Array

FEATURES = ("mean", "deviation", "low", "high", "rate")
"""Features of a window: mean, logarithm of the standard deviation, 5 and 95 % quantiles, crossings of the mean."""
FLOOR = 0.01
"""Least error of model and sensor together, over the standard deviation of the record."""
_SHRINKAGE = 0.3

Channels = Mapping[str, Array]
"""Values by channel: of the record of shape (T,), of M runs of shape (M, T)."""


def of_series(record: Channels, runs: Channels, period: float, window: float) -> Array:
    """Logarithm of the likelihood of the time series of each run, shape (M,); Gaussian errors of unknown size.

    The size of the error of each channel is integrated out (Jeffreys' prior: -n/2 log of the sum of squares; Gelman and
    others 2013, section 3.2). n is the number of independent samples, from the autocorrelation of the errors of
    the best run: an error of the model lasts longer than a sample. An error below `FLOOR` counts as that.

    Args:
        record: The record.
        runs: The runs.
        period: Time from sample to sample [s]; unused.
        window: Unused.
    """
    del period, window
    total = np.zeros(len(next(iter(runs.values()))))
    for channel, values in runs.items():
        error = values - record[channel]
        square = np.mean(error**2, axis=1) + (FLOOR * np.std(record[channel])) ** 2
        square = np.where(np.isfinite(square), square, np.inf)
        independent = independent_samples(error[np.argmin(square)])
        total -= 0.5 * independent * np.log(np.maximum(square, np.finfo(float).tiny))  # a constant record: no floor
    return total


def of_features(record: Channels, runs: Channels, period: float, window: float) -> Array:
    """Logarithm of the likelihood of the mean features of windows of each run, shape (M,).

    For motion whose phase is not determined. Windows scatter; the covariance of a mean is that of the windows of
    record and run over their number, shrunk towards its diagonal (Ledoit and Wolf 2004), as windows are few.

    Args:
        record: The record.
        runs: The runs.
        period: Time from sample to sample [s].
        window: Length of a window [s].
    """
    seen = np.concatenate([features(values[None], period, window) for values in record.values()], axis=2)[0]
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


LIKELIHOODS: Mapping[str, Callable[[Channels, Channels, float, float], Array]] = {
    "series": of_series,
    "features": of_features,
}
"""Likelihoods by name."""


def features(values: Array, period: float, window: float) -> Array:
    """Features of windows that follow one another, shape (M, windows, 5), of values of shape (M, T)."""
    length = max(8, round(window / period))
    count = max(1, values.shape[1] // length)
    parts = values[:, : count * length].reshape(len(values), count, -1)
    centred = parts - parts.mean(axis=2, keepdims=True)
    crossings = np.sum(np.diff(np.signbit(centred), axis=2), axis=2) / (2.0 * length * period)
    low, high = np.quantile(parts, (0.05, 0.95), axis=2)
    deviation = np.log(parts.std(axis=2) + 1e-12)
    return np.stack((parts.mean(axis=2), deviation, low, high, crossings), axis=2)


def independent_samples(error: Array) -> float:
    """Number of independent samples of a series: its length over its correlation time in samples.

    The sum of the autocorrelation ends at the first pair of lags that is not positive (Geyer 1992, initial positive
    sequence).
    """
    count = error.size
    centred = error - error.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * count)) ** 2
    correlation = np.fft.irfft(spectrum)[:count]
    if correlation[0] <= 0.0:
        return float(count)
    correlation /= correlation[0]
    pairs = correlation[1 : 2 * ((count - 1) // 2) + 1].reshape(-1, 2).sum(axis=1)
    last = int(np.argmax(pairs <= 0.0)) if np.any(pairs <= 0.0) else pairs.size
    return float(np.clip(count / (1.0 + 2.0 * pairs[:last].sum()), 2.0, count))


def _covariance(windows: Array) -> Array:
    """Covariance of windows, shape (windows, F), shrunk towards its diagonal."""
    spread = windows - windows.mean(axis=0)
    found: Array = spread.T @ spread / max(1, len(windows) - 1)
    floor = (1e-3 * (np.abs(windows).mean(axis=0) + 1e-9)) ** 2
    return (1.0 - _SHRINKAGE) * found + np.diag(_SHRINKAGE * np.diag(found) + floor)
