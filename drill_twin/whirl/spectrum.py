# SPDX-License-Identifier: Apache-2.0
"""Two-sided spectrum of a whole record of a mark's centre line: forward and backward whirl apart.

Offline, for reports. A complex record z = x + i y has a spectrum with two different sides: a forward orbit is a line
at a positive frequency, a backward orbit at a negative frequency (Lee and Lee 1997, directional spectra of rotors).

Irregular motion has no single frequency: its highest line and its mean precession differ, and both depend on the length
of the record.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl.marks import AnalysisError

FEWEST = 16
"""Fewest samples of a spectrum; chosen, not measured."""
LEAST_LINE = 0.1
"""Least radius of a listed line over the radius of the highest line; chosen, not measured."""


@dataclass(frozen=True)
class Peak:
    """A line of the spectrum."""

    frequency: float
    """Frequency [Hz], signed, right-handed about +z."""
    radius: float
    """Radius of a circular orbit with a line of this height [m]."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Two-sided spectrum of the centre line."""

    frequency: Array
    """Frequencies [Hz], rising through zero, shape (k,)."""
    radius: Array
    """Radius of the orbit at each frequency [m], shape (k,): for a circular orbit, its own radius."""
    resolution: float
    """Width of a line [Hz]."""

    def peak(self, low: float, high: float) -> Peak | None:
        """Highest line between two frequencies [Hz]; None if there is none.

        The frequency is refined by a parabola through the logarithm of the three highest points.
        """
        inside = (self.frequency >= low) & (self.frequency <= high)
        if not inside.any():
            return None
        at = int(np.argmax(np.where(inside, self.radius, -1.0)))
        if self.radius[at] <= 0.0:
            return None
        frequency = float(self.frequency[at])
        if 0 < at < self.radius.size - 1 and self.radius[at - 1 : at + 2].min() > 0.0:
            left, middle, right = np.log(self.radius[at - 1 : at + 2]).tolist()
            bend = left - 2.0 * middle + right
            if bend < 0.0:
                share = 0.5 * (left - right) / bend  # formula of a parabola's top
                frequency += share * float(self.frequency[1] - self.frequency[0])
        return Peak(frequency, float(self.radius[at]))

    def lines(self, count: int) -> list[Peak]:
        """Highest lines, highest first: local maxima, two widths apart and off zero, a tenth of the highest or more."""
        inner = self.radius[1:-1]
        highest = (inner > self.radius[:-2]) & (inner >= self.radius[2:])
        places = np.flatnonzero(highest & (np.abs(self.frequency[1:-1]) > 1.5 * self.resolution)) + 1
        found: list[Peak] = []
        for at in places[np.argsort(-self.radius[places])].tolist():
            line = self.peak(float(self.frequency[at - 1]), float(self.frequency[at + 1]))
            if line is None or len(found) == count or (found and line.radius < LEAST_LINE * found[0].radius):
                break
            if all(abs(line.frequency - other.frequency) > 2.0 * self.resolution for other in found):
                found.append(line)
        return found


def two_sided_spectrum(time: Array, z: ComplexArray, *, segment: float | None = None) -> Spectrum:
    """Spectrum of a record (Welch 1967: Hann windows, half overlap, mean power; offset removed).

    Args:
        time: Times of the samples [s], rising, shape (n,); an irregular record is interpolated linearly on its mean
            grid.
        z: Centre line [m], shape (n,); samples that are not finite are ignored.
        segment: Length of a segment [s]; the whole record by default.

    Raises:
        AnalysisError: Fewer than 16 finite samples, or times that do not rise.
    """
    time, z = _finite(time, z)
    if time.size < FEWEST:
        raise AnalysisError(f"expected at least {FEWEST} finite samples for a spectrum, found {time.size}")
    if not (np.diff(time) > 0).all():
        raise AnalysisError("expected times that rise from sample to sample, found some that do not; sort the record")
    _, even = _evenly(time, z)
    rate = (time.size - 1) / (time[-1] - time[0])
    length = time.size if segment is None else min(time.size, max(FEWEST, round(segment * rate)))
    padded = 2 ** math.ceil(math.log2(2 * length))
    # As scipy.signal.welch, whose import takes 0.5 s of each run.
    window = 0.5 - 0.5 * np.cos(math.tau * np.arange(length) / length)  # formula of Hann's window
    parts = np.lib.stride_tricks.sliding_window_view(even, length)[:: length - length // 2]
    lines = np.fft.fft(window * (parts - parts.mean(axis=1, keepdims=True)), padded) / window.sum()
    frequency, power = np.fft.fftfreq(padded, 1.0 / rate), (np.abs(lines) ** 2).mean(axis=0)
    order = np.argsort(frequency)
    return Spectrum(frequency[order], np.sqrt(power[order]), 1.5 * rate / length)


def spectrum_over_time(time: Array, z: ComplexArray, window: float, columns: int = 400) -> tuple[Array, Array, Array]:
    """Two-sided spectra of a record in a sliding Hann window: times [s], frequencies [Hz] and radii [m].

    Shapes (c,), (k,) and (k, c). A circular orbit has its own radius; a constant offset is at zero. Near an end of the
    record the window is shorter on that side, down to an eighth, so that the spectra reach over the whole record.

    Args:
        time: Times of the samples [s], rising, shape (n,); interpolated linearly on their mean grid.
        z: Centre line [m], shape (n,); samples that are not finite are ignored.
        window: Length of the window [s].
        columns: Largest number of windows.

    Raises:
        AnalysisError: The record is shorter than the window, or has fewer than 16 finite samples in one.
    """
    time, z = _finite(time, z)
    rate = (time.size - 1) / float(time[-1] - time[0]) if time.size > 1 else 0.0
    length = round(window * rate)
    if length < FEWEST or length > time.size:
        raise AnalysisError(
            f"expected a record of at least {window:.3g} s with {FEWEST} finite samples in it, found {time.size}"
        )
    grid, even = _evenly(time, z)
    centres = np.unique(np.linspace(0, time.size - 1, min(columns, time.size)).astype(np.intp))
    place, taper = _tapers(centres, length, time.size)
    padded = 2 ** math.ceil(math.log2(2 * length))
    spectra = np.fft.fftshift(np.fft.fft(even[place] * taper, padded, axis=1), axes=1)
    radius = np.abs(spectra) / taper.sum(axis=1, keepdims=True)
    frequency = np.fft.fftshift(np.fft.fftfreq(padded, 1.0 / rate))
    return grid[centres], frequency, radius.T


def _finite(time: Array, z: ComplexArray) -> tuple[Array, ComplexArray]:
    good = np.isfinite(time) & np.isfinite(z.real) & np.isfinite(z.imag)
    return np.asarray(time, float)[good], np.asarray(z, complex)[good]


def _evenly(time: Array, z: ComplexArray) -> tuple[Array, ComplexArray]:
    """Record on the mean grid of its times."""
    grid = np.linspace(time[0], time[-1], time.size)
    return grid, np.interp(grid, time, z.real) + 1j * np.interp(grid, time, z.imag)


def _tapers(centres: NDArray[np.intp], length: int, samples: int) -> tuple[NDArray[np.intp], Array]:
    """Samples of the windows around centres and their Hann weights, shape (c, length); shorter towards an end."""
    half, least = length // 2, length // 8
    middle = np.clip(centres, least, samples - 1 - least)[:, None]
    step = np.arange(length) - half
    side = np.where(step < 0, np.minimum(middle, half), np.minimum(samples - 1 - middle, half)) + 1.0
    taper = np.where(np.abs(step) < side, 0.5 + 0.5 * np.cos(math.pi * step / side), 0.0)
    return np.clip(middle + step, 0, samples - 1), taper


LINES = 3
"""Lines of the spectrum that are listed; chosen, not measured."""
SEGMENT = 40.0
"""Length of a segment of the spectrum [rev]; chosen, not measured."""


def lines_of(time: Array, centre: ComplexArray, rotation: float) -> list[Peak]:
    """Highest lines of a mark, highest first, positive = the sense of rotation; none of too short a record.

    Args:
        time: Times of the samples [s], rising, shape (n,).
        centre: Centre line z = x + i y [m], shape (n,).
        rotation: Mean rotation [rev/s], signed, not 0.
    """
    try:
        spectrum = two_sided_spectrum(time, centre, segment=SEGMENT / abs(rotation))
    except AnalysisError:
        return []
    return [Peak(math.copysign(1.0, rotation) * line.frequency, line.radius) for line in spectrum.lines(LINES)]
