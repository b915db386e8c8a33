# SPDX-License-Identifier: Apache-2.0
"""Kinematic records: prescribed labelled motions, measured with noise, drop-outs, jitter and quantisation.

Every record is random with a seed: steady rotation of a bent string, then one motion and then another. Radii are
fractions of the clearance, times are in revolutions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.ground_truth import STATES_PER_TURN, WHIRL_THRESHOLD, Truth, onset

MOTIONS = (
    "forward whirl",
    "rolling along the wall",
    "second bending",
    "irregular",
    "backward whirl",
    "spiral",
)
"""Motions of a record after its steady rotation."""
STEADY_LENGTH, MOTION_LENGTH = 10.0, 24.0
"""Length of the steady rotation at the start and of each motion [rev]."""
BLEND = 1.5
"""Length of the change from one motion to the next [rev]."""
TOUCHING = 0.98
"""Radius over the clearance from which the string touches the wall [-]."""
HOLES = ((0.08175, 0.00825), (0.03675, 0.00825), (0.0539, 0.1016), (0.3, 0.09))
"""Clearance and outer radius [m]: the bench, the bench with 90 mm as diameter, 8 in in 12 1/4 in, and a wide hole."""


@dataclass(frozen=True, eq=False)
class Record:
    """Measured signals of camera and rig, and the ground truth; T samples, m marks."""

    name: str
    marks: tuple[MarkInfo, ...]
    stamp: NDArray[np.int64]
    """Stamps [ns], shape (T,)."""
    position: Array
    """Marked points [m], shape (T, m, 2); nan where not seen."""
    spin: Array | None
    """Spin at the marks [rad], shape (T, m); None where it is not measured."""
    top_speed: Array
    """Top speed [rad/s], shape (T,)."""
    force: Array | None
    """Wall force [N], shape (T, m); None where it is not measured."""
    truth: Truth
    rotation: float
    """Rotation after the start [rev/s], not negative."""


@dataclass(frozen=True)
class _Motion:
    name: str
    ratio: float
    level: float
    shape: ComplexArray


def labelled(seed: int) -> Record:
    """A labelled record, the same for the same seed: steady rotation, then two motions."""
    draw = np.random.default_rng([seed, 6])
    clearance, outer = HOLES[int(draw.integers(len(HOLES)))]
    heights = int(draw.integers(3, 6))
    marks = tuple(
        MarkInfo(f"mark_{k + 1}", 1.0 + k, "wall" if draw.random() < 0.8 else "centre", outer, clearance)
        for k in range(heights)
    )
    first = MOTIONS[seed % len(MOTIONS)]
    second = MOTIONS[(seed + 1 + (seed // len(MOTIONS)) % (len(MOTIONS) - 1)) % len(MOTIONS)]
    motions = [_random_motion(name, draw, marks) for name in (first, second)]
    time, rate, speed = _sample_times(draw)
    angle = speed * math.tau * time  # the string rotates when the record begins
    revolutions = np.abs(angle) / math.tau
    growth = draw.uniform(0.4, 4.0)
    part, change = _blended(motions, revolutions, angle, growth, draw)
    spin = angle[:, None] - 0.3 * np.arange(heights)
    rolls = any(motion.name == MOTIONS[1] for motion in motions)
    offset = 0.0 if rolls else draw.uniform(0.0, 0.15) * np.exp(1j * draw.uniform(0.0, math.tau))
    rest = offset + draw.uniform(0.0, 0.06) * np.exp(1j * (spin + draw.uniform(0.0, math.tau)))
    centre = part + rest
    centre /= np.maximum(np.abs(centre), 1.0)
    truth = _truth(motions, time, angle, part, change)
    return _observed(f"{seed}: {first}, {second}", marks, time, spin, speed, centre, truth, draw, rate)


def steady(seed: int, noise: float = 0.05) -> Record:
    """A record without whirl: rotation of a bent, eccentric string, with `noise` over the clearance on each axis."""
    draw = np.random.default_rng([seed, 7])
    clearance, outer = HOLES[int(draw.integers(len(HOLES)))]
    marks = tuple(MarkInfo(f"mark_{k + 1}", 1.0 + k, "wall", outer, clearance) for k in range(4))
    time, rate, speed = _sample_times(draw)
    angle = speed * math.tau * time
    spin = angle[:, None] - 0.3 * np.arange(4)
    rest = draw.uniform(0.0, 0.5) + draw.uniform(0.0, 0.2) * np.exp(1j * (spin + draw.uniform(0.0, math.tau)))
    at = np.searchsorted(np.abs(angle) / math.tau, np.arange(0.0, abs(angle[-1]) / math.tau, 1.0 / STATES_PER_TURN))
    still = tuple("rotation about a fixed axis" for _ in at)
    truth = Truth(None, (None,) * 4, time[at], still, (still,) * 4)
    return _observed(f"{seed}: steady", marks, time, spin, speed, rest, truth, draw, rate, noise=noise)


def _random_motion(name: str, draw: np.random.Generator, marks: tuple[MarkInfo, ...]) -> _Motion:
    """A motion of a name, with random ratio, level and shape."""
    m = len(marks)
    ratio = float(draw.choice([draw.uniform(0.15, 0.8), draw.uniform(1.2, 1.6), -draw.uniform(0.1, 1.2)]))
    level = float(draw.uniform(0.2, 0.85))
    along = np.linspace(0.0, 1.0, m)
    shape = (1.0 - draw.uniform(0.0, 0.5) * along) * np.exp(1j * draw.uniform(-0.15, 0.15, m))
    if name == "forward whirl":
        ratio = abs(ratio)
    elif name == "backward whirl":
        ratio = -float(draw.uniform(0.1, 1.2))
    elif name == "rolling along the wall":
        ratio = marks[0].rolling_ratio * float(draw.uniform(0.85, 1.15))
        level, shape = 1.0, np.ones(m, complex)
    elif name == "second bending":
        shape = np.cos(math.pi * along * draw.uniform(0.9, 1.0)).astype(complex)
    elif name == "spiral":
        shape = np.exp(1j * float(draw.choice([-1.0, 1.0])) * draw.uniform(0.6, 1.3) * np.arange(m))
    else:
        level = float(draw.uniform(0.3, 0.45))
    return _Motion(name, ratio, level, shape.astype(complex))


def _sample_times(draw: np.random.Generator) -> tuple[Array, float, float]:
    """Sample times [s], their rate [Hz] and the speed [rev/s, signed]; 6 to 400 samples in a revolution."""
    rate = float(np.exp(draw.uniform(math.log(20.0), math.log(2000.0))))
    speed = float(draw.uniform(max(0.5, rate / 400.0), min(6.0, rate / 6.0)))
    count = int((STEADY_LENGTH + 2.0 * MOTION_LENGTH) / speed * rate)
    time = np.arange(count) / rate
    jitter = draw.uniform(0.0, 0.3) / rate
    time = np.sort(time + draw.normal(size=count) * jitter)
    time = time - time[0]
    return time, rate, float(draw.choice([-1.0, 1.0])) * speed


def _blended(
    motions: list[_Motion], revolutions: Array, angle: Array, growth: float, draw: np.random.Generator
) -> tuple[ComplexArray, float]:
    """The asynchronous part over the clearance, shape (T, m), and the time of the second motion [rev]."""
    change = STEADY_LENGTH + MOTION_LENGTH
    parts = []
    for number, motion in enumerate(motions):
        if motion.name == "irregular":
            path = _wandering(revolutions, draw)
        else:
            path = np.exp(1j * (motion.ratio * angle + draw.uniform(0.0, math.tau)))
        part = motion.level * path[:, None] * motion.shape
        if number == 0:
            grown = WHIRL_THRESHOLD / motion.level * np.exp(np.minimum(growth * (revolutions - STEADY_LENGTH), 50.0))
            part = part * (grown / (1.0 + grown))[:, None]
        parts.append(part)
    x = np.clip((revolutions - change) / BLEND + 0.5, 0.0, 1.0)[:, None]
    share = x * x * (3.0 - 2.0 * x)
    return (1.0 - share) * parts[0] + share * parts[1], change


def _wandering(revolutions: Array, draw: np.random.Generator) -> ComplexArray:
    """Irregular path: complex Gaussian noise, most of it within 0.6 of the rotation."""
    lines = 24
    pace = draw.normal(0.0, 0.6, lines)
    phase = draw.uniform(0.0, math.tau, lines)
    path: ComplexArray = np.exp(1j * (math.tau * revolutions[:, None] * pace + phase)).sum(axis=1) / math.sqrt(lines)
    return path


def _truth(motions: list[_Motion], time: Array, angle: Array, part: ComplexArray, change: float) -> Truth:
    revolutions, radius = np.abs(angle) / math.tau, np.abs(part)
    at = np.searchsorted(revolutions, np.arange(0.0, revolutions[-1], 1.0 / STATES_PER_TURN))
    at = at[at < time.size]
    onsets = tuple(onset(time, part[:, k], angle) for k in range(radius.shape[1]))
    known = [found for found in onsets if found is not None]
    first = min(known)
    string, marks = [], [[] for _ in onsets]  # type: tuple[list[str], list[list[str]]]
    for i in at:
        motion = motions[0] if revolutions[i] < change else motions[1]
        name = motion.name
        if name == "rolling along the wall" and radius[i, 0] < TOUCHING:
            name = "backward whirl"  # still growing
        string.append("rotation about a fixed axis" if time[i] < first else name)
        for k, mine in enumerate(marks):
            began = onsets[k]
            mine.append(
                "rotation about a fixed axis" if began is None or time[i] < began else _of_mark(motion, name, k)
            )
    return Truth(first, onsets, time[at], tuple(string), tuple(tuple(mine) for mine in marks))


def _of_mark(motion: _Motion, name: str, mark: int) -> str:
    """Motion of a mark during a motion of the string; empty where its radius is too small."""
    if abs(motion.shape[mark]) * motion.level < 2.0 * WHIRL_THRESHOLD:
        return ""
    if name in {"second bending", "spiral"}:
        return "forward whirl" if motion.ratio > 0.0 else "backward whirl"
    return name


def _observed(
    name: str,
    marks: tuple[MarkInfo, ...],
    time: Array,
    spin: Array,
    speed: float,
    centre: ComplexArray,
    truth: Truth,
    draw: np.random.Generator,
    rate: float,
    noise: float | None = None,
) -> Record:
    """Record of a centre line over the clearance, shape (T, m)."""
    scale = marks[0].clearance
    arm = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks])
    level = float(draw.uniform(0.0, 0.03)) if noise is None else noise
    z = centre * scale + arm * np.exp(1j * spin)
    z = z + level * scale * (draw.normal(size=z.shape) + 1j * draw.normal(size=z.shape))
    step = float(draw.uniform(0.0, 0.01)) * scale
    place = np.stack((np.round(z.real / step), np.round(z.imag / step)), axis=-1) * step
    place[draw.random(place.shape[:2]) < draw.uniform(0.0, 0.1)] = math.nan
    kept = draw.random(time.size) >= draw.uniform(0.0, 0.15)
    sees_spin, feels = draw.random() < 0.7, draw.random() < 0.5
    force = (np.abs(centre) > TOUCHING).astype(float) if feels else None
    stamp = np.round(time * 1e9).astype(np.int64)
    _, once = np.unique(stamp, return_index=True)
    kept &= np.isin(np.arange(time.size), once)
    return Record(
        f"{name}, {rate:.0f} Hz, {speed:.2f} rev/s, noise {100 * level:.1f} %{'' if sees_spin else ', no spin'}",
        marks,
        stamp[kept],
        place[kept],
        spin[kept] if sees_spin else None,
        np.full(int(kept.sum()), math.tau * speed),
        None if force is None else force[kept],
        truth,
        abs(speed),
    )
