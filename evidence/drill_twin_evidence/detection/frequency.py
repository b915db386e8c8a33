# SPDX-License-Identifier: Apache-2.0
"""Whirl frequency of drawn motions of known frequency, and how often the printed interval holds it.

`python -m drill_twin_evidence.detection.frequency 200 SEED`. A mark on the centre line turns at 2 rev/s; from 3 s on it
whirls at 0.3 to 0.9 of the clearance, seen at 100 Hz with noise of 0.2 to 5 % of the clearance. Its precession is
written down here by kind and shares nothing with `drill_twin.whirl`:

* constant: one ratio, -8 to 0.9.
* modulated: one ratio of a rotation that swings by up to 80 % at 0.1 to 0.3 Hz, as in stick-slip.
* wandering: about one frequency, with a correlation time of 0.5 to 3 s and a deviation of 2 to 10 % of the rotation.
* alternating: two ratios of opposite sense in turn, for 8 to 20 s each.
* drifting: from one frequency to another 30 to 100 % of the rotation away, all the time.

The weighted mode is the centroid of the highest cells of a histogram of the ratio since the onset, by power.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.table import Table
from drill_twin.whirl import Analyzer, MarkInfo
from drill_twin.whirl.findings import Summary
from drill_twin_evidence.proportion import proportion_text

RATE, ROTATION, BEGIN = 100.0, 2.0, 3.0
"""Samples in a second [Hz], mean rotation [rev/s] and begin of the whirl [s]."""
CLEARANCE = 0.01
MARK = MarkInfo("mark", 1.0, "centre", 0.02, CLEARANCE)
CELL = 0.02
"""Width of a cell of the histogram of the ratio, and three cells on each side belong to its peak."""


class Drawn(NamedTuple):
    """A drawn motion; n samples."""

    time: Array
    """Times [s], shape (n,)."""
    rotation: Array
    """Rotation [rev/s], shape (n,)."""
    frequency: Array
    """Precession [Hz], shape (n,)."""
    settled: tuple[float, ...]
    """Frequencies that are right [Hz]; none where the motion changes all the time."""


def _constant(time: Array, draw: np.random.Generator) -> Drawn:
    ratio = _ratio(draw)
    rotation = np.full_like(time, ROTATION)
    return Drawn(time, rotation, ratio * rotation, (ratio * ROTATION,))


def _modulated(time: Array, draw: np.random.Generator) -> Drawn:
    ratio, pace, swing = _ratio(draw), draw.uniform(0.1, 0.3), draw.uniform(0.2, 0.8)
    rotation = ROTATION * (1.0 + swing * np.sin(2.0 * np.pi * pace * time + draw.uniform(0.0, 6.0)))
    return Drawn(time, rotation, ratio * rotation, (ratio * ROTATION,))


def _wandering(time: Array, draw: np.random.Generator) -> Drawn:
    frequency, memory = _ratio(draw) * ROTATION, math.exp(-1.0 / RATE / draw.uniform(0.5, 3.0))
    part, deviation = np.zeros_like(time), draw.uniform(0.02, 0.1) * ROTATION
    kicks = deviation * math.sqrt(1.0 - memory**2) * draw.standard_normal(time.size)
    part[0] = deviation * draw.standard_normal()
    for i in range(1, time.size):
        part[i] = memory * part[i - 1] + kicks[i]
    return Drawn(time, np.full_like(time, ROTATION), frequency + part, (frequency,))


def _alternating(time: Array, draw: np.random.Generator) -> Drawn:
    pair = ROTATION * np.array([draw.uniform(0.3, 0.9), draw.uniform(-3.0, -0.3)])
    ends = np.cumsum(draw.uniform(8.0, 20.0, time.size // 100))
    which = (np.searchsorted(ends, time) + draw.integers(2)) % 2
    return Drawn(time, np.full_like(time, ROTATION), pair[which], tuple(pair.tolist()))


def _drifting(time: Array, draw: np.random.Generator) -> Drawn:
    first, change = _ratio(draw), draw.choice((-1.0, 1.0)) * draw.uniform(0.3, 1.0)
    rotation = np.full_like(time, ROTATION)
    return Drawn(time, rotation, (first + change * time / time[-1]) * rotation, ())


def _ratio(draw: np.random.Generator) -> float:
    return float(draw.choice((draw.uniform(0.1, 0.9), draw.uniform(-1.0, -0.1), draw.uniform(-8.0, -1.0))))


KINDS: dict[str, Callable[[Array, np.random.Generator], Drawn]] = {
    "constant": _constant, "modulated": _modulated, "wandering": _wandering, "alternating": _alternating,
    "drifting": _drifting,
}  # fmt: skip


class Found(NamedTuple):
    """Findings of a drawn motion."""

    drawn: Drawn
    summary: Summary
    mode: float
    """Weighted mode of the precession since the onset [Hz]."""


def analysed(kind: str, seed: int, seconds: float | None = None) -> Found:
    """Draw a motion of a kind for a time [s], by default 25 to 90 s, and analyse it."""
    draw = np.random.default_rng([seed, list(KINDS).index(kind)])
    time = np.arange(0.0, draw.uniform(25.0, 90.0) if seconds is None else seconds, 1.0 / RATE)
    drawn = KINDS[kind](time, draw)
    radius = draw.uniform(0.3, 0.9) / (1.0 + np.exp(-4.0 * (time - BEGIN)))
    place = radius * np.exp(2j * np.pi * np.cumsum(drawn.frequency) / RATE)
    place += draw.uniform(0.002, 0.05) * (draw.standard_normal(time.size) + 1j * draw.standard_normal(time.size))
    position = CLEARANCE * np.stack((place.real, place.imag, 0.0 * time), axis=-1)[:, None]
    analyzer, speed = Analyzer((MARK,)), 2.0 * np.pi * drawn.rotation
    rows = analyzer.push_block(np.rint(1e9 * time).astype(np.int64), position, None, speed, None, speed)
    summary, values = analyzer.summary(), rows.values[:, 0]
    return Found(drawn, summary, _mode(time, values, summary.onset_s))


def _mode(time: Array, values: Array, onset: float | None) -> float:
    """Weighted mode [Hz] of rows of radius, precession, ratio and confidence, shape (n, 4); NaN without an onset."""
    known = np.isfinite(values).all(axis=1) & (time >= (math.inf if onset is None else onset))
    if not known.any():
        return math.nan
    radius, precession, ratio, _ = values[known].T
    cells = np.arange(ratio.min() - 4.0 * CELL, ratio.max() + 5.0 * CELL, CELL)
    place = np.searchsorted(cells, ratio)
    power = np.convolve(np.bincount(place, radius**2, cells.size), np.ones(7), "same")
    near = np.abs(place - int(np.argmax(power))) <= 3
    return float(np.average(precession[near], weights=radius[near] ** 2))


def counts(kind: str, found: list[Found]) -> tuple[str, ...]:
    """A row of the table: errors, and the shares that are changing, undecided, and held where neither."""
    finals = [(one, one.summary.whirl_frequency_hz) for one in found]
    told = [(one, hz) for one, hz in finals if hz is not None]
    settled = [(one, hz) for one, hz in told if one.summary.whirl_frequency_changes is False]
    error = [min((abs(hz - right) for right in one.drawn.settled), default=math.nan) for one, hz in told]
    mode = [min((abs(one.mode - right) for right in one.drawn.settled), default=math.nan) for one, _ in told]
    errors = (", ".join(f"{1e3 * np.quantile(one, share):.2g}" for share in (0.5, 0.9)) for one in (error, mode))
    return (
        kind, f"{len(told)} of {len(found)}", *errors,
        str(sum(bool(one.summary.whirl_frequency_changes) for one, _ in told)),
        str(sum(one.summary.whirl_frequency_changes is None for one, _ in told)),
        proportion_text(sum(holds(one) for one, _ in settled), len(settled)) if kind != "drifting" else "",
    )  # fmt: skip


def holds(found: Found) -> bool:
    """True if the printed interval holds a right frequency."""
    low, high = found.summary.whirl_frequency_interval_hz or (math.nan, math.nan)
    return any(low <= right <= high for right in found.drawn.settled)


def lines(count: int, seed: int) -> Iterator[str]:
    """The table as Markdown, of so many motions of each kind."""
    heading = (
        "motion", "has a frequency", "error [mHz]: median, 90 %", "of the weighted mode", "still changing", "too short",
        "interval holds the frequency",
    )  # fmt: skip
    rows = [counts(kind, [analysed(kind, seed + one) for one in range(count)]) for kind in KINDS]
    yield Table(heading, rows).markdown()


if __name__ == "__main__":
    print("\n".join(lines(int(sys.argv[1]), int(sys.argv[2]))))
