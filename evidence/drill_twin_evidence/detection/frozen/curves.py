# SPDX-License-Identifier: Apache-2.0
"""Errors of a detector as curves: false alarms over noise, delay over growth and noise, swings called whirl."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.frozen.measured import HOLES, Errors, measured, turning
from drill_twin_evidence.detection.frozen.motions import Motion, assembled, ellipse, exponential, resting, within
from drill_twin_evidence.detection.frozen.score import Detector
from drill_twin_evidence.detection.frozen.truth import BACKWARD, FIXED, FORWARD, SWING, FrozenRecord

FIRST = 4_700_000
"""First seed of these records; nothing was tuned on it or on those after it."""
NOISE, COLOURS = (0.01, 0.02, 0.03, 0.05, 0.08, 0.12), (0.0, 1.0)
"""Noise on each axis over the clearance, white and with a power that falls as 1/f."""
GROWTH, NOISE_OF_DELAY = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0), (0.005, 0.02, 0.05)
"""Growth in a revolution [e-foldings]; noise of the growing orbits."""
AXES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)
"""Ratio of the half axes of an ellipse."""
MINUTES, PER_TURN, MARKS = 6.0, 12.0, 4
"""Length of a record of noise alone [min]: an onset in it counts as one alarm; samples in a revolution; marks."""


@dataclass
class Curves:
    """Measured curves of one detector."""

    hours: float
    """Hours of noise alone at each level."""
    each: int
    """Records at each point of the other curves."""
    alarms: dict[float, list[float]] = field(default_factory=dict)
    """Alarms an hour over `NOISE`, by colour."""
    delay: dict[float, list[float]] = field(default_factory=dict)
    """Median of announcement minus true onset [rev] over `GROWTH`, by noise; nan where fewer than half are found."""
    error: dict[float, list[float]] = field(default_factory=dict)
    """Median size of found minus true onset [rev]."""
    whirl: dict[str, list[float]] = field(default_factory=dict)
    """Share of ellipses called whirl over `AXES`, in a vertical and in an inclined hole."""

    def plain(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return vars(self)


def curves_of(detector: Detector, hours: float = 20.0, each: int = 16) -> Curves:
    """Measure a detector: so many hours at each level of noise, so many records at each point of the other curves."""
    found = Curves(hours, each)
    parts = max(1, round(hours * 60.0 / MINUTES))
    for colour in COLOURS:
        rates = []
        for noise in NOISE:
            alarms = sum(detector(_noise(noise, colour, part)).onset is not None for part in range(parts))
            rates.append(alarms / (parts * MINUTES / 60.0))
        found.alarms[colour] = rates
    for noise in NOISE_OF_DELAY:
        pairs = [_delays(detector, growth, noise, each) for growth in GROWTH]
        found.delay[noise], found.error[noise] = ([pair[i] for pair in pairs] for i in (0, 1))
    for name, inclined in (("vertical", False), ("inclined", True)):
        found.whirl[name] = [
            float(np.mean([detector(_ellipse(axes, inclined, k)).onset is not None for k in range(each)]))
            for axes in AXES
        ]
    return found


def _marks(*, inclined: bool = False, count: int = 3, hole: int = 0) -> tuple[MarkInfo, ...]:
    clearance, outer = HOLES[hole]
    return tuple(MarkInfo(f"mark_{k + 1}", 1.0 + k, "wall", outer, clearance, inclined) for k in range(count))


def _noise(noise: float, colour: float, number: int) -> FrozenRecord:
    """Rotation of a bent string that lies aside, with noise."""
    draw, marks = np.random.default_rng([FIRST + number, round(1e3 * noise), round(10 * colour)]), _marks(count=MARKS)
    samples = turning(draw, 60.0 * MINUTES * 2.0, PER_TURN)
    # A turn of half a second, so that an hour has the same number of turns in every record.
    samples = samples._replace(time=samples.time * abs(samples.speed[0]) / (2.0 * math.tau),
                               speed=samples.sense * np.full(samples.time.size, 2.0 * math.tau))  # fmt: skip
    still = Motion(FIXED, None, np.ones(samples.time.size, complex), 1e-6, np.ones(MARKS, complex))
    part, truth = assembled(samples, [still], np.full(samples.time.size, 1e-6))
    centre = within(part + resting(samples, draw, 0.3, 0.1, MARKS))
    return measured("n", "noise", marks, samples, centre, truth, Errors(noise, colour), draw, sees_spin=True)


def _delays(detector: Detector, growth: float, noise: float, each: int) -> tuple[float, float]:
    """Median delay of the announcement and size of the error [rev] of an orbit that grows."""
    delays, errors = [], []
    for number in range(each):
        draw = np.random.default_rng([FIRST + number, round(1e3 * growth), round(1e3 * noise), 2])
        samples = turning(draw, 16.0 + 5.5 / growth + 16.0, float(draw.uniform(16.0, 40.0)))
        ratio = float(draw.choice([draw.uniform(0.15, 0.85), draw.uniform(1.2, 1.6), -draw.uniform(0.15, 1.2)]))
        state, marks = FORWARD if ratio > 0.0 else BACKWARD, _marks()
        motion = Motion(state, ratio, ellipse(samples, ratio, 1.0, draw), 0.5, np.ones(len(marks), complex))
        part, truth = assembled(samples, [motion], exponential(samples, 0.5, growth, 14.0))
        centre = within(part + resting(samples, draw, 0.1, 0.06, len(marks)))
        record = measured("n", "growth", marks, samples, centre, truth, Errors(noise), draw, sees_spin=True)
        found = detector(record)
        true = truth.began(found.level)
        if found.onset is not None and found.announced is not None:
            began, at, known = np.interp([true, found.onset, found.announced], truth.time, truth.turns)
            delays.append(float(known - began))
            errors.append(abs(float(at - began)))
    if 2 * len(delays) < each:
        return math.nan, math.nan
    return float(np.median(delays)), float(np.median(errors))


def _ellipse(axes: float, inclined: bool, number: int) -> FrozenRecord:
    """An ellipse of a random direction that grows; on the low side where the hole is inclined."""
    draw, marks = (
        np.random.default_rng([FIRST + number, round(1e3 * axes), int(inclined), 3]),
        _marks(inclined=inclined),
    )
    samples = turning(draw, 70.0, float(draw.uniform(16.0, 40.0)))
    ratio = float(draw.choice([draw.uniform(0.15, 0.85), draw.uniform(1.2, 1.6)]) * draw.choice([-1.0, 1.0]))
    level = float(draw.uniform(0.12, 0.22 if inclined else 0.5))
    motion = Motion(SWING, ratio, ellipse(samples, ratio, axes, draw), level, np.ones(len(marks), complex))
    size = exponential(samples, level, float(draw.uniform(0.3, 2.0)), 14.0)
    part, truth = assembled(samples, [motion], size)
    centre = within((0.55 if inclined else 0.0) + part + resting(samples, draw, 0.05, 0.05, len(marks)))
    return measured("n", "ellipse", marks, samples, centre, truth, Errors(0.01), draw, sees_spin=True)


def rows_of(curves: Curves) -> Iterator[tuple[str, tuple[str, ...], list[tuple[object, ...]]]]:
    """Title, heads and rows of each table."""
    alarms = [
        (f"{'white' if colour == 0.0 else '1/f'}", *(f"{rate:.2g}" for rate in rates))
        for colour, rates in curves.alarms.items()
    ]
    yield (
        f"Alarms an hour on noise alone ({curves.hours:g} h at each level, four marks, 2 rev/s), over noise/clearance",
        ("noise", *(f"{100 * noise:g} %" for noise in NOISE)), list(alarms),
    )  # fmt: skip
    for title, table in (("Announced after the true onset", curves.delay), ("Size of the onset's error", curves.error)):
        rows = [(f"{100 * noise:g} %", *(f"{value:.2f}" for value in values)) for noise, values in table.items()]
        yield (
            f"{title} [rev], median of {curves.each}, over e-foldings in a revolution",
            ("noise", *(f"{growth:g}" for growth in GROWTH)), list(rows),
        )  # fmt: skip
    whirl = [(name, *(f"{100 * share:.0f} %" for share in shares)) for name, shares in curves.whirl.items()]
    yield (
        f"Ellipses called whirl, of {curves.each}, over the ratio of their half axes",
        ("hole", *(f"{axes:g}" for axes in AXES)), list(whirl),
    )  # fmt: skip
