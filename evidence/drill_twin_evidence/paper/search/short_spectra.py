# SPDX-License-Identifier: Apache-2.0
"""Lines of short plain spectra: readings that give 0.28 and 0.29 Hz by the length of the window alone.

A spectrum of T seconds without zero padding has lines at whole multiples of 1 / T, the lowest at 0.286 Hz for 3.5 s.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.runs.published import FREQUENCY
from drill_twin_evidence.paper.search.evaluate import Bench
from drill_twin_evidence.paper.search.readings import (
    BASE,
    FRAME_RATE,
    MARKS,
    NEAR,
    NUMBERS,
    Motion,
    crossings,
    wall_points,
)  # fmt: skip
from drill_twin_evidence.paper.search.space import Trial

WINDOWS = (2.5, 3.5, 5.0, 10.0)
"""Lengths from the onset on [s]."""
SIGNALS = ("x", "radius", "speed")
READ = tuple(number for number in NUMBERS if number.what == FREQUENCY)


class Short(NamedTuple):
    """Reading that meets the two frequencies at high load."""

    reading: str
    lines: tuple[float, ...]
    """Highest line for each of `READ` [Hz]."""
    first: bool
    """True if those at high load are the lowest lines that the spectrum has."""


def short_spectra(bench: Bench, one: Trial) -> list[Short]:
    """Readings of a set that give 0.28 and 0.29 Hz."""
    motions = [bench.motion(one, Case(number.weight_on_bit, number.speed)) for number in READ]
    if any(motion is None for motion in motions):
        return []
    found = []
    for (k, mark), signal, seconds in product(enumerate(MARKS), SIGNALS, WINDOWS):
        lines = tuple(_line(motion, k, signal, seconds) for motion in motions if motion is not None)
        off = [abs(line / number.value - 1.0) / 0.2 for line, number in zip(lines, READ, strict=True)]
        if max(off[1:]) <= NEAR:
            name = f"{signal} of {mark}, {seconds:g} s after the onset"
            found.append(Short(name, lines, max(lines[1:]) * seconds < 1.5))
    return found


def _line(motion: Motion, mark: int, signal: str, seconds: float) -> float:
    onset = crossings(motion.time, motion.centre, motion.clearance)[BASE["time"]]
    if not np.isfinite(onset):
        return float("nan")
    since = int(onset * FRAME_RATE)
    point = wall_points(motion)[:, mark]
    series: dict[str, Array] = {"x": point.real, "radius": np.abs(point), "speed": np.abs(np.gradient(point))}
    x = series[signal][since : since + round(seconds * FRAME_RATE)]
    return float((1 + np.argmax(np.abs(np.fft.rfft(x - x.mean()))[1:])) * FRAME_RATE / x.size)
