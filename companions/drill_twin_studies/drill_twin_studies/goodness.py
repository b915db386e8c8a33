# SPDX-License-Identifier: Apache-2.0
"""Goodness of fit of a channel: what is measured less what is computed, against the noise of the record itself."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy import special

from drill_twin.core.arrays import Array
from drill_twin.core.table import Table

BAND = 0.9
"""Share of the samples that a predicted band is to hold."""
HALF_WIDTH = float(special.ndtri(0.5 + 0.5 * BAND))
"""Half width of that band, in standard deviations."""
_DIFFERENCES = np.array([1.0, -3.0, 3.0, -1.0]) / math.sqrt(20.0)
"""Third differences, of unit variance for white noise."""
SCATTER = 2.62
"""Variance of the ratio of mean square to mean square of `_DIFFERENCES` of N white samples, times N.

The ratio is 1 + 1.5 r_1 - 0.6 r_2 + 0.1 r_3 to first order in the autocorrelations r_k of the samples, which have the
variance 1 / N each (Bartlett 1946): the third-order form of the ratio of von Neumann (1941)."""
_UNLIKELY = 1e-3
"""Chance with which the residual of a model that is right is called unexplained, for one channel."""
FEWEST = 10
"""Samples from which noise can be told; not measured."""


@dataclass(frozen=True)
class Goodness:
    """Measures of how well a model explains a channel.

    Attributes:
        samples: Number of samples that were compared.
        residual: Rms of measured less computed [SI].
        noise: Standard deviation of the errors that are expected of the samples [SI].
        correlation: Autocorrelation of the residual from sample to sample; 0 for noise.
        independent: Number of independent samples of the residual.
        chi_square: Mean square of the residual over its predicted variance: 1 for predictions as good as they say.
        inside: Share of the samples inside the predicted band of 90 %.
        limit: Chi-square that one in 1,000 right models exceeds; NaN where it is not judged.
        correlation_limit: Autocorrelation times chi-square that one in 1,000 exceeds; None where it is not judged.
        of: What is judged: samples, or features of windows, of which `samples` counts the windows.
        against: What the residual is compared with.
    """

    samples: int
    residual: float
    noise: float
    correlation: float
    independent: float
    chi_square: float
    inside: float
    limit: float
    correlation_limit: float | None = None
    of: str = "samples"
    against: str = "the noise"

    @property
    def ratio(self) -> float:
        """Rms residual over the noise; NaN where the samples are too few to tell it, or have none."""
        return self.residual / self.noise if self.noise > 0.0 else math.nan

    def over_noise(self, of: str = "") -> str:
        """Ratio in words, with what it is a multiple of; samples of a slow record do not tell noise from motion."""
        return f"{self.ratio:.3g} {of}".rstrip() if self.noise > 0.0 else "over noise not known" if of else "not known"

    @property
    def lasting(self) -> bool:
        """True if the residual goes on from sample to sample as noise does not."""
        return self.correlation_limit is not None and self.correlation * self.chi_square > self.correlation_limit

    @property
    def explained(self) -> bool:
        """True if chance explains the residual, or if there is none."""
        return not (self.chi_square > self.limit or self.lasting)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {**asdict(self), "residual_over_noise": self.ratio, "explained": self.explained}


def goodness(
    measured: Array,
    computed: Array,
    spread: Array | float,
    noise: float,
    error: float,
    limit: float,
    correlation_limit: float | None = None,
) -> Goodness:
    """Goodness of a channel.

    Args:
        measured: Samples in their order, shape (T,); NaN where missing.
        computed: What the model says, shape (T,).
        spread: Standard deviation of `computed`, without errors of the samples, shape (T,).
        noise: Standard deviation of the noise of the samples.
        error: Standard deviation of the errors that predictions count with.
        limit: Chi-square from which the model does not explain the channel.
        correlation_limit: Autocorrelation times chi-square from which it does not.
    """
    known = np.isfinite(measured)
    residual = (measured - computed)[known]
    if residual.size == 0:
        return Goodness(0, math.nan, noise, math.nan, 0.0, math.nan, math.nan, limit, correlation_limit)
    variance = np.maximum(np.broadcast_to(spread, known.shape)[known] ** 2 + error**2, np.finfo(float).tiny)
    return Goodness(
        samples=residual.size,
        residual=float(np.sqrt(np.mean(residual**2))),
        noise=noise,
        correlation=lag_one(residual),
        independent=independent_samples(residual),
        chi_square=float(np.mean(residual**2 / variance)),
        inside=float(np.mean(np.abs(residual) <= HALF_WIDTH * np.sqrt(variance))),
        limit=limit,
        correlation_limit=correlation_limit,
    )


def sentence(found: Mapping[str, Goodness]) -> str:
    """Sentence on the channels, by name, that the model does not explain; empty if it explains all."""
    parts = [
        f"{name.replace('_', ' ')} (residual {one.over_noise(f'times {one.against}')}"
        + f", {one.inside:.0%} of the {one.of} in the band of {BAND:.0%}" * (one.chi_square > one.limit)
        + f", but it lasts: {one.correlation:+.2f} from sample to sample, where noise has 0" * one.lasting
        + ")"
        for name, one in found.items()
        if not one.explained
    ]
    return f"the model does not explain {', '.join(parts)}" if parts else ""


def table(found: Mapping[str, Goodness]) -> Table:
    """Table for people of the goodness of channels by name."""
    rows = [
        (name, one.samples, one.over_noise(), f"{one.correlation:+.2f}".replace("+nan", "-"),
         f"{one.independent:.0f}", f"{one.chi_square:.3g}", f"{one.inside:.0%}")
        for name, one in found.items()
    ]  # fmt: skip
    heading = (
        "channel",
        "samples",
        "residual / noise",
        "from sample to sample",
        "independent",
        "chi-square",
        "in band",
    )
    return Table(heading, rows, title="how well the model explains the record", right=(1, 2, 3, 4, 5, 6))


def limit_of_samples(samples: int) -> float:
    """Chi-square of white samples against `noise_of` themselves that is exceeded by chance in one of 1,000 cases.

    Its logarithm is normal, of variance `SCATTER` over their number; the ratio itself is skew.
    """
    return math.exp(-float(special.ndtri(_UNLIKELY)) * math.sqrt(SCATTER / max(samples, 1)))


def correlation_limit(samples: int) -> float:
    """Autocorrelation of white samples that is exceeded by chance in one of 1,000 cases (Bartlett 1946)."""
    return -float(special.ndtri(_UNLIKELY)) / math.sqrt(max(samples, 1))


def noise_of(values: Array) -> float:
    """Standard deviation of the noise of a series, shape (T,), NaN where missing, from its third differences.

    A motion that is smooth from sample to sample has none (Gasser, Sroka and Jennen-Steinmetz 1986; Hall, Kay and
    Titterington 1990); all else counts as noise. 0 for fewer samples than tell it.
    """
    differences = np.convolve(values, _DIFFERENCES, "valid") if values.size >= _DIFFERENCES.size else values[:0]
    known = differences[np.isfinite(differences)]
    return float(np.sqrt(np.mean(known**2))) if known.size >= FEWEST else 0.0


def lag_one(values: Array) -> float:
    """Autocorrelation of a series from sample to sample; 0 for a constant one."""
    centred = values - values.mean()
    square = float(centred @ centred)
    return float(centred[1:] @ centred[:-1]) / square if square > 0.0 else 0.0


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
