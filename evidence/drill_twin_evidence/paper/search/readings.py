# SPDX-License-Identifier: Apache-2.0
"""Readings of a motion: the numbers that one who looks at curves and spectra could have taken from it, by name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.runs.published import CRITICAL_TIME, DISPLACEMENT, FREQUENCY, RATIO, Number, published

NUMBERS = published().bench
FRAME_RATE = 40.0
"""Frames per second: the line of 6.5 rev/s lies well below half of it."""
COARSE = 6
"""Frames from one sample to the next of 150 ms, 200 in 30 s."""
LOWEST_LINE = 0.1
"""Least frequency that counts as a line [Hz]: below, a drift."""
FINER = 4
"""Zero padding of the spectra."""
MARKS = ("mark_1", "mark_2", "mark_3")
LEVELS = {"1 mm": (1e-3, 0.0), "5 % of the clearance": (0.0, 0.05), "half the clearance": (0.0, 0.5)}
"""Displacement of the centre line that ends the quiet phase: metres, and a share of the clearance."""
TIMES = tuple(f"{level}, {where}" for level in LEVELS for where in ("any mark", "mark_2"))
KINDS = {CRITICAL_TIME: "time", FREQUENCY: "whirl", RATIO: "whirl", DISPLACEMENT: "size"}
BASE = {"time": "5 % of the clearance, any mark", "whirl": "precession of mark_2", "size": "wall, 30 s"}
"""Readings of `drill-twin study paper`, as near as these come; numbers of one kind are read in one way."""
IRREGULAR = 0.2
"""Spread of the precession from which a motion is irregular."""
LARGEST = 8.0
"""Limit of a misfit, in units of 20 %."""
NEAR = 1.0
"""Misfit of a number that counts as met: 20 %."""


class Motion(NamedTuple):
    """Motion of the marks in a run."""

    time: Array
    """Ends of the frames [s], shape (T,)."""
    centre: ComplexArray
    """Centre line at `MARKS`, x + i y [m], shape (T, 3)."""
    angle: Array
    """Angle of rotation [rad], shape (T,)."""
    surface: float
    """Radius of the string [m]."""
    clearance: float
    """[m]"""

    def paths(self, mark: str) -> dict[str, ComplexArray]:
        """A marked point on the string's surface ("wall") and the centre line there, x + i y [m], of both lengths."""
        centre, half = self.centre[:, MARKS.index(mark)], self.time.size // 2
        wall = centre + self.surface * np.exp(1j * self.angle)
        return {"wall, 30 s": wall, "wall, last half": wall[half:],
                "centre, 30 s": centre, "centre, last half": centre[half:]}  # fmt: skip

    def window_rates(self, windows: int = 5) -> Array:
        """Mean rate of precession of each mark in windows of the last half [Hz], shape (windows, 3)."""
        half = self.time.size // 2
        turned = np.unwrap(np.angle(self.centre[half:]), axis=0)
        edges = np.linspace(0, turned.shape[0] - 1, windows + 1).astype(int)
        spent = np.diff(self.time[half:][edges])[:, None]
        return np.asarray(np.diff(turned[edges], axis=0) / spent / math.tau)

    def crossings(self) -> dict[str, float]:
        """First time beyond each of `LEVELS`, at any mark and at mark_2 [s], as `TIMES`; NaN: never."""
        radius = np.abs(self.centre)
        beyond = [values >= limit for limit in limits(self.clearance) for values in (radius.max(axis=1), radius[:, 1])]
        first = (float(self.time[np.argmax(late)]) if late.any() else math.nan for late in beyond)
        return dict(zip(TIMES, first, strict=True))


@dataclass(frozen=True)
class Readings:
    """All readings of one run by their names, to four digits: as they are in a record."""

    weight_on_bit: float
    """[N]"""
    speed: float
    """[rev/s]"""
    time: dict[str, float]
    """Critical times [s]; NaN: none."""
    whirl: dict[str, float]
    """Frequencies [Hz]; those of the precession with a sign."""
    size: dict[str, dict[str, float]]
    """Largest displacement along x or y [m], by mark and reading."""
    spread: float
    """Range of the precession of mark_2 over windows of the last half, over its mean; large: irregular."""


Results = dict[Case, Readings]
"""Readings by run."""


def limits(clearance: float) -> Array:
    """The levels [m]."""
    return np.array([metres + share * clearance for metres, share in LEVELS.values()])


def read(case: Case, motion: Motion) -> Readings:
    """All readings of a run."""
    rates = motion.window_rates()
    whirl = {f"precession of {mark}": rate for mark, rate in zip(MARKS, rates.mean(axis=0), strict=True)}
    size: dict[str, dict[str, float]] = {}
    for mark in MARKS:
        paths = motion.paths(mark)
        for (name, path), every in product(paths.items(), (1, COARSE)):
            reading = f"highest line of {mark}, {name}, every {1e3 * every / FRAME_RATE:g} ms"
            whirl[reading] = highest_line(path[::every].real, every / FRAME_RATE)
        size[mark] = _short(
            {name: max(np.abs(path.real).max(), np.abs(path.imag).max()) for name, path in paths.items()}
        )
    (spread,) = _short({"": float(np.ptp(rates[:, 1]) / max(abs(rates[:, 1].mean()), 1e-3))}).values()
    return Readings(*case, _short(motion.crossings()), _short(whirl), size, spread)


def failed(case: Case) -> Readings:
    """Readings of a run that failed: none is near."""
    still = read(case, Motion(np.arange(1.0, 100.0), np.zeros((99, 3), complex), np.zeros(99), 0.0, 1.0))
    nothing = {mark: dict.fromkeys(sizes, math.nan) for mark, sizes in still.size.items()}
    return Readings(*case, dict.fromkeys(still.time, math.nan), dict.fromkeys(still.whirl, math.nan), nothing, 0.0)


def _short(values: dict[str, float]) -> dict[str, float]:
    return {name: float(f"{value:.4g}") for name, value in values.items()}


def highest_line(x: Array, period: float) -> float:
    """Frequency of the highest line of a spectrum with a Hann window [Hz], a parabola through its top.

    Args:
        x: Samples, shape (T,).
        period: Time between them [s].
    """
    height = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(x.size), FINER * x.size))
    resolution = 1.0 / (period * FINER * x.size)
    least = max(1, math.ceil(LOWEST_LINE / resolution))
    k = least + int(np.argmax(height[least:]))
    if k < height.size - 1:
        a, b, c = height[k - 1 : k + 2]
        bend = a - 2.0 * b + c
        return float((k + (0.5 * (a - c) / bend if bend < 0.0 else 0.0)) * resolution)
    return float(k * resolution)


def values_of(number: Number, found: Readings) -> dict[str, float]:
    """A number in each reading of its kind, in its own unit; the sense of a whirl frequency is not published."""
    if number.what == CRITICAL_TIME:
        return found.time
    if number.what == DISPLACEMENT:
        return {name: 1e3 * size for name, size in found.size[number.mark].items()}
    return {
        name: abs(whirl) if number.what == FREQUENCY else whirl / number.speed for name, whirl in found.whirl.items()
    }


def misfit(number: Number, ours: Array) -> Array:
    """Misfit of values of a number, in units of 20 % and at most 8."""
    off = np.abs(ours / number.value - 1.0) / 0.2
    return np.asarray(np.minimum(np.where(np.isfinite(off), off, LARGEST), LARGEST))


def misfits(results: Results, kind: str, *, any_reading: bool) -> Array:
    """Misfits of the numbers of a kind, shape (numbers, readings); infinite where a run was not made.

    Args:
        results: Readings by run.
        kind: "time", "whirl" or "size".
        any_reading: In all readings of the kind, in their order; or in that of `BASE` alone.
    """
    rows = []
    for number in of_kind(kind):
        found = results.get(number.case)
        given = values_of(number, found) if found else {}
        chosen = list(given) if any_reading else [BASE[kind]]
        rows.append(misfit(number, np.array([given[name] for name in chosen])) if given else np.array([np.inf]))
    width = max(row.size for row in rows)
    return np.array([np.broadcast_to(row, width) if np.isinf(row).all() else row for row in rows])


def of_kind(kind: str) -> list[Number]:
    """Numbers of a kind, in order."""
    return [number for number in NUMBERS if KINDS[number.what] == kind]
