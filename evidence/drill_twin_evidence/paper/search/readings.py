# SPDX-License-Identifier: Apache-2.0
"""Readings of a motion: the numbers that one who looks at curves and spectra could have taken from it."""

from __future__ import annotations

import math
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
LEVELS = {"1 mm": 1e-3, "5 % of the clearance": -0.05, "half the clearance": -0.5}
"""Displacement of the centre line that ends the quiet phase [m]; negative: of the clearance."""
KINDS = {CRITICAL_TIME: "time", FREQUENCY: "whirl", RATIO: "whirl", DISPLACEMENT: "size"}
TIMES = tuple(f"{level}, {where}" for level, where in product(LEVELS, ("any mark", "mark_2")))
WHIRLS = (
    *(f"precession of {mark}" for mark in MARKS),
    *(
        f"highest line of {mark}, {on}, {part}, every {sampled}"
        for mark, on, part, sampled in product(MARKS, ("wall", "centre"), ("30 s", "last half"), ("25 ms", "150 ms"))
    ),
)
SIZES = tuple(f"{on}, {part}" for on, part in product(("wall", "centre"), ("30 s", "last half")))
READINGS = {"time": TIMES, "whirl": WHIRLS, "size": SIZES}
"""Readings by kind; numbers of one kind are read in one way."""
BASE = {
    "time": TIMES.index("5 % of the clearance, any mark"),
    "whirl": WHIRLS.index("precession of mark_2"),
    "size": SIZES.index("wall, 30 s"),
}
"""Readings of `drill-twin paper`, as near as these come."""
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


class Readings(NamedTuple):
    """All readings of one run."""

    time: Array
    """Critical times [s], shape of `TIMES`; NaN: none."""
    whirl: Array
    """Frequencies [Hz], shape of `WHIRLS`; those of the precession with a sign."""
    size: Array
    """Largest displacement of each mark [m], shape (3, sizes)."""
    spread: float
    """Range of the precession of mark_2 over windows of the last half, over its mean; large: irregular."""


Results = dict[Case, Readings]
"""Readings by run."""


def read(motion: Motion) -> Readings:
    """All readings of a run."""
    wall, half = wall_points(motion), motion.time.size // 2
    rates = window_rates(motion)
    lines = []
    for mark in range(len(MARKS)):
        for place in (wall, motion.centre):
            for part in (place[:, mark].real, place[half:, mark].real):
                lines += [highest_line(part, 1.0), highest_line(part[::COARSE], float(COARSE))]
    size = np.array([[
        max(np.abs(part.real).max(), np.abs(part.imag).max())
        for place in (wall, motion.centre) for part in (place[:, mark], place[half:, mark])
    ] for mark in range(len(MARKS))])  # fmt: skip
    mean = rates.mean(axis=0)
    spread = float(np.ptp(rates[:, 1]) / max(abs(mean[1]), 1e-3))
    return Readings(crossings(motion.time, motion.centre, motion.clearance), np.array([*mean, *lines]), size, spread)


def wall_points(motion: Motion) -> ComplexArray:
    """Marked points on the string's surface, x + i y [m], shape (T, 3)."""
    return np.asarray(motion.centre + motion.surface * np.exp(1j * motion.angle)[:, None])


def crossings(time: Array, centre: ComplexArray, clearance: float) -> Array:
    """First times at which the centre line is beyond each level, at any mark and at mark_2."""
    radius = np.abs(centre)
    found = []
    for level in LEVELS.values():
        limit = level if level > 0.0 else -level * clearance
        for value in (radius.max(axis=1), radius[:, 1]):
            beyond = value >= limit
            first = int(np.argmax(beyond))
            found.append(float(time[first]) if beyond[first] else math.nan)
    return np.array(found)


def highest_line(x: Array, every: float) -> float:
    """Frequency of the highest line of a spectrum with a Hann window [Hz], a parabola through its top.

    Args:
        x: Samples, shape (T,).
        every: Frames between them.
    """
    window = np.hanning(x.size)
    height = np.abs(np.fft.rfft((x - x.mean()) * window, FINER * x.size))
    resolution = FRAME_RATE / every / (FINER * x.size)
    least = max(1, math.ceil(LOWEST_LINE / resolution))
    k = least + int(np.argmax(height[least:]))
    if 0 < k < height.size - 1:
        a, b, c = height[k - 1 : k + 2]
        bend = a - 2.0 * b + c
        return float((k + (0.5 * (a - c) / bend if bend < 0.0 else 0.0)) * resolution)
    return float(k * resolution)


def window_rates(motion: Motion, windows: int = 5) -> Array:
    """Mean rate of precession of each mark in windows of the last half [Hz], shape (windows, 3)."""
    half = motion.time.size // 2
    turned = np.unwrap(np.angle(motion.centre[half:]), axis=0)
    edges = np.linspace(0, turned.shape[0] - 1, windows + 1).astype(int)
    spent = np.diff(motion.time[half:][edges])[:, None]
    return np.asarray(np.diff(turned[edges], axis=0) / spent / math.tau)


def misfits(results: Results) -> dict[str, Array]:
    """Misfit of each number in each reading of its kind, in units of 20 % and at most 8; NaN: its run was not made.

    Args:
        results: Readings by run.

    Returns:
        By kind, shape (numbers of the kind, readings).
    """
    table: dict[str, list[Array]] = {kind: [] for kind in READINGS}
    for number in NUMBERS:
        kind, found = KINDS[number.what], results.get(Case(number.weight_on_bit, number.speed))
        table[kind].append(np.full(len(READINGS[kind]), np.nan) if found is None else misfit(number, found))
    return {kind: np.array(rows) for kind, rows in table.items()}


def misfit(number: Number, found: Readings) -> Array:
    """Misfit of one number in each reading of its kind."""
    off = np.abs(values(number, found) / number.value - 1.0) / 0.2
    return np.asarray(np.minimum(np.where(np.isfinite(off), off, LARGEST), LARGEST))


def values(number: Number, found: Readings) -> Array:
    """A number in each reading of its kind, in its own unit; the sense of a whirl frequency is not published."""
    if number.what == CRITICAL_TIME:
        return found.time
    if number.what == DISPLACEMENT:
        return np.asarray(1e3 * found.size[MARKS.index(number.mark)])
    return np.asarray(np.abs(found.whirl) if number.what == FREQUENCY else found.whirl / number.speed)


def of_kind(kind: str) -> list[int]:
    """Places in `NUMBERS` of the numbers of a kind, in order."""
    return [k for k, number in enumerate(NUMBERS) if KINDS[number.what] == kind]
