# SPDX-License-Identifier: Apache-2.0
"""Windows of what is measured, what the members predict for them, and the estimate at the end of a window."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from scipy import special

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.io.messages.topic_words import SENSORS
from drill_twin_studies.estimation.doubts import Span, told_of_jumps, told_of_spans
from drill_twin_studies.fitting.posterior import UNDETERMINED
from drill_twin_studies.fitting.sampling import Ranges, in_ranges
from drill_twin_studies.goodness import Goodness

SHARE = 0.9
"""Share of the members in a band: the probability of the true value if the members were draws of what is known."""
_ENDS = special.ndtri(0.5 + 0.5 * SHARE * np.array([[-1.0], [1.0]]))

HELD = (
    f"low and high are bands of {SHARE:.0%}; on twins with hidden numbers they held in 257 of 300 (wall friction "
    "with a sub) to 299 of 300 (friction at the bit without one); withheld while the model does not explain what is "
    "measured; wrong after a step too small to be reported, as of friction at the bit of a whirling rod"
)
"""Counts by `drill-twin study estimator-score` of bands of numbers that held (docs/drill_twin_studies/bands.md)."""


@dataclass(frozen=True)
class Band:
    """Mean, standard deviation, and band of 90 % of the members; `HELD` says how often a band holds the truth."""

    mean: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Array, factor: float = 1.0) -> Self:
        """Band of the values of the members, shape (N,), widened about their mean by a factor."""
        mean = values.mean()
        low, high = mean + factor * (np.quantile(values, (0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE)) - mean)
        low = max(low, 0.0) if values.min() >= 0.0 else low
        return cls(float(mean), factor * float(values.std(ddof=1)), float(low), float(high))


def untold_of(normal: Array, ranges: Ranges, factor: float) -> dict[str, float]:
    """Share of its range that the band of `bands_of` covers, by key of each number that the record does not tell."""
    low, high = shares_of(normal, factor)
    shares = zip(ranges, (high - low).tolist(), strict=True)
    return {key: share for key, share in shares if share > UNDETERMINED}


UNTOLD = Band(math.nan, math.nan, math.nan, math.nan)
"""Band of what is withheld."""
_DRAWS = special.ndtri((np.arange(100) + 0.5) / 100)[:, None]
"""Places of 100 draws from the standard normal distribution, of equal probability."""


def shares_of(normal: Array, factor: float, places: Array = _ENDS) -> Array:
    """Places in the ranges, from 0 to 1, of the ends of the bands of numbers, shape (2, d).

    A filter for near-linear motion knows a mean and a variance, in the space where the prior is standard normal. The
    filter mixes the members, so single members have no more to say.

    Args:
        normal: Numbers of the members in this space, shape (N, d).
        factor: Factor of the deviations of the numbers.
        places: Other places than the ends, in standard deviations, shape (k, 1).
    """
    return np.asarray(special.ndtr(normal.mean(axis=0) + factor * places * normal.std(axis=0, ddof=1)))


def bands_of(normal: Array, ranges: Ranges, factor: float) -> dict[str, Band]:
    """Bands of free numbers [SI] by key; a deviation is computed from draws within the range, however wide the band.

    Args:
        normal: Numbers of the members, as in `shares_of`.
        ranges: Ranges of the numbers by key.
        factor: Factor of their deviations.
    """
    mean = in_ranges(special.ndtr(normal), ranges).mean(axis=0)
    deviation = in_ranges(shares_of(normal, factor, _DRAWS), ranges).std(axis=0)
    low, high = in_ranges(shares_of(normal, factor), ranges)
    rows = zip(mean, deviation, low, high, strict=True)
    return {key: Band(*map(float, row)) for key, row in zip(ranges, rows, strict=True)}


def shown_unit(sensor: str, units: UnitSystem) -> tuple[float, str]:
    """Number of the reader's units in the SI unit of a virtual sensor, and their name; radii and places are offsets."""
    unit = SENSORS.get(sensor, "m")  # a place of a mark has no entry
    return (float(units.show(1.0, "offset")), units.offset) if unit == "m" else units.in_unit(unit)


REACH = 2.5
"""Longest time over which a sample is a mean [s], and so the time before a window that a mean may reach back to: the
slowest record has 0.5 Hz, and its stamps vary."""


class WindowTiming(NamedTuple):
    """Lengths in time.

    Attributes:
        period: Length of a frame [s].
        frames: Frames of a window.
        samples: Most samples of a window.
    """

    period: float
    frames: int
    samples: int

    @property
    def window(self) -> float:
        """Length of a window [s]."""
        return self.period * self.frames

    @property
    def tail(self) -> int:
        """Frames before a window that its means may reach back to."""
        return math.ceil(REACH / self.period)


class Prediction(NamedTuple):
    """A window of N members.

    Attributes:
        channels: Channels by name, shape (N, S): means over the time of each sample of the window, 0 where there is
            none.
        sensors: Virtual sensors by name, each of shape (N,).
        whirls: True for a member that whirls, shape (N,).
        readings: Readings of the subs, shape (N, F, s, 6) (`drill_twin_studies.estimation.subs`).
        speeds: Speeds of the bit at the ends of the frames [rad/s], shape (N, F).
    """

    channels: Mapping[str, Array]
    sensors: Mapping[str, Array]
    whirls: Mask
    readings: Array
    speeds: Array


_WINDOWS, _POINTS = 20, 20
"""Windows in which a cycle is looked for, and points of a window that are kept; not measured."""
_SWINGS = 0.2
"""Standard deviation of the bit's speed over its mean from which it swings: 0.85 in stick-slip, at most 0.03 in
scenes that whirl, whose bands hold at 10 Hz though the bit follows the whirl."""
_FEWEST = 4.0
"""Samples in a cycle from which its phase is told: two are the limit of Nyquist, for a sine without noise."""

_FAST = ("bit_speed", "bit_torque")
"""Virtual sensors that change within a cycle of torsion."""


class Swing:
    """Torsional swing of the members over the last windows."""

    def __init__(self, pace: WindowTiming) -> None:
        self._pace, self._every = pace, max(1, pace.frames // _POINTS)
        self._last: deque[Array] = deque(maxlen=_WINDOWS)

    def take(self, speeds: Array) -> None:
        """Take the speed of the bit in a window [rad/s], shape (N, F)."""
        self._last.append(speeds[:, :: self._every])

    @property
    def cycle(self) -> float:
        """Time of a cycle [s], of the highest line of the spectrum; infinite where most members do not swing."""
        speeds = np.concatenate(list(self._last), axis=1)
        mean = speeds.mean(axis=1, keepdims=True)
        if np.median(speeds.std(axis=1) - _SWINGS * np.abs(mean[:, 0])) <= 0.0:
            return math.inf
        lines = (np.abs(np.fft.rfft((speeds - mean) * np.hanning(speeds.shape[1]))) ** 2).sum(axis=0)
        line = 1 + int(np.argmax(lines[1:]))
        near = slice(line - 1, line + 2)  # main lobe of the window of Hann
        frequency = float(np.arange(lines.size)[near] @ lines[near] / lines[near].sum())
        return float(speeds.shape[1] * self._every * self._pace.period / frequency)

    def withheld(self, spacing: float) -> dict[str, str]:
        """Reason why samples at a distance [s] do not tell the virtual sensors of `_FAST`, by name; none if they do."""
        samples = self.cycle / float(np.fmax(spacing, self._pace.window / self._pace.samples))
        if samples >= _FEWEST:
            return {}
        few = f"{samples:.1f} samples in a cycle of {self.cycle:.2g} s do not tell its phase: expected {_FEWEST:g}"
        return dict.fromkeys(_FAST, few)


@dataclass(frozen=True)
class FilterWindow:
    """Set-points and measured samples of a window of time.

    Attributes:
        commands: Set-points at the end of each frame, as a `Command`, shape (F, 3).
        measured: Samples by channel, shape (S,) each; NaN where there is none.
        weights: Share of each frame in the time of a sample, of the C channels, shape (C, `WindowTiming.tail` + F, S):
            the frames of a member times the weights are compared with the samples; 0 where there is no sample.
        readings: Readings of s subs at the frames, shape (s, F, 6); NaN for a sub that has none.
        spacing: Usual time from sample to sample of the channels that show torsion [s]; NaN where it is not known.
        between: True for a window without samples, in which none was due.
    """

    commands: Array
    measured: Mapping[str, Array]
    weights: Array
    readings: Array | None = None
    spacing: float = math.nan
    between: bool = False


@dataclass(frozen=True)
class Estimate:
    """Estimate at the end of a window.

    Attributes:
        time: Time [s].
        numbers: Free numbers [SI] by key.
        untold: Share of its range that the band covers, by key of each number that the record does not tell.
        sensors: Virtual sensors by name, see `drill_twin.io.messages.topic_words.SENSORS`; with a sub also the
            places of the centre line at the marks at the end of the window [m], MARK/x and MARK/y.
        withheld: Reason why a virtual sensor has no band, and no mean, by name.
        whirls: Share of the members that whirl.
        chance: Share of the members that whirl within the horizon; NaN if it is not computed.
        unexplained: Time since which a channel is not explained [s], by name; virtual sensors are withheld then.
        jumps: Time of a jump [s], by key of each number that is looked for anew; by `UNEXPLAINED`, if none explains it.
        misfit: Rms of measured less predicted over the scale, by channel; NaN where nothing was measured.
        goodness: How well the members explain each channel over the last windows, against the stated errors, by name.
        absurd: Samples left out so far.
        unmeasured: Time for which nothing sound has been measured [s]: the ensemble runs alone.
        frames: Frames of the member that was nearest to the rig before the window; None unless asked for.
        spans: Windows with an alarm so far.
    """

    time: float
    numbers: Mapping[str, Band]
    untold: Mapping[str, float]
    sensors: Mapping[str, Band]
    withheld: Mapping[str, str]
    whirls: float
    chance: float
    unexplained: Mapping[str, float]
    jumps: Mapping[str, float]
    misfit: Mapping[str, float]
    goodness: Mapping[str, Goodness]
    absurd: int
    unmeasured: float
    frames: Frames | None
    spans: Sequence[Span] = ()

    @property
    def alarm(self) -> str:
        """Sentences while the members do not explain what is measured; empty while they do."""
        parts = [f"{name} since {time:.1f} s" for name, time in self.unexplained.items()]
        told = [f"the model does not explain {', '.join(parts)}: virtual sensors are withheld"] if parts else []
        told += filter(None, [told_of_jumps(self.jumps)])
        causes = "the motion has changed, or the rig differs from the model"
        return f"{'; '.join(told)}; {causes}" if told else ""

    @property
    def remembered(self) -> str:
        """Sentence on all windows with an alarm so far, whether one stands or not; empty without."""
        return told_of_spans(self.spans)
