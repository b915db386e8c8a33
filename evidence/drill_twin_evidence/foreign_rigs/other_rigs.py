# SPDX-License-Identifier: Apache-2.0
"""Records of a minute of rigs of other kinds, and what is true of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.foreign_rigs.other_motion import DEPTH_OF_CUT, HYPERBOLIC, LUGRE, STEP, Machine, motion
from drill_twin_evidence.foreign_rigs.rigs import (
    DECAY,
    INDICATED,
    LOAD,
    PERIOD,
    RADIUS,
    SLIDING,
    STICKING,
    with_noise,
)
from drill_twin_studies.fitting import Record

SECONDS = 60.0
"""Length of a record [s]."""


@dataclass(frozen=True)
class Kind:
    """A kind of rig and its instruments.

    Attributes:
        machine: Numbers that differ from those of the scene.
        numbers: Friction numbers of the scene that it has.
        offset: Of the torque sensor, over the largest torque.
        drift: Relative growth of the torque's reading until the end of the record.
        late: Time by which the torque arrives late [s].
        most: Share of the largest torque at which its sensor saturates.
        noise: Of a sample, over the largest value of its channel.
        averaged: Whether a sample is the mean since the last one.
        gaps: Number of gaps.
        kept: Whether it is kept back: nothing was chosen by it.
        own: Whether it is of the scene's equations, numbers apart.
    """

    machine: Mapping[str, Any] = field(default_factory=dict)
    numbers: tuple[str, ...] = (STICKING, SLIDING, LOAD)
    offset: float = 0.0
    drift: float = 0.0
    late: float = 0.0
    most: float = np.inf
    noise: float = 0.01
    averaged: bool = True
    gaps: int = 0
    kept: bool = False
    own: bool = False


_STRING = {"string_inertia": 140.0, "springs": 12}
KINDS: Mapping[str, Kind] = {
    "own": Kind(own=True, numbers=(STICKING, SLIDING, DECAY, LOAD)),
    "own, steady": Kind({"speed": 8.0}, own=True, numbers=(STICKING, SLIDING, DECAY, LOAD)),
    "own, noise of 4 %": Kind(noise=0.04, own=True, numbers=(STICKING, SLIDING, DECAY, LOAD)),
    "new rock": Kind({"change": -0.15, "change_time": 40.0}, own=True, numbers=(STICKING, SLIDING, DECAY, LOAD)),
    "hyperbolic, lag, offset, gaps": Kind(
        {"law": HYPERBOLIC, "lag": 0.2, **_STRING}, offset=0.02, gaps=3, averaged=False
    ),
    "depth of cut": Kind(
        {"law": DEPTH_OF_CUT, "speed": 1.2, "string_damping": 40.0, "bit_damping": 0.0}, numbers=(LOAD,)
    ),
    "backlash, late, drift": Kind({"play": 0.3}, late=0.4, drift=0.05),
    "LuGre": Kind({"law": LUGRE, **_STRING}),
    "sagging drive": Kind({"droop": 0.3, "power": 14e3}),
    "patches": Kind({"patches": 0.12}),
    "wandering rock": Kind({"wander": 0.06}),
    "mud and wall": Kind({"drag": 40.0, "wall": 500.0, **_STRING}, kept=True),
    "strengthening": Kind({"viscous": 180.0, "decay": 2.0}, kept=True),
    "saturated": Kind(most=0.85, kept=True),
    "late by 0.15 s, stiff": Kind({"stiffness": 960.0}, late=0.15, kept=True),
    "backlash, instantaneous": Kind({"play": 0.15, "lag": 0.1}, averaged=False, kept=True),
    "drive of other gains": Kind({"proportional": 4000.0, "integral": 2000.0}, kept=True),
}
"""Kinds by name."""


@dataclass(frozen=True)
class Recorded:
    """A record, its truth at the end, and the speed of the bit [rad/s] at the end of each second."""

    record: Record
    truth: Mapping[str, float]
    bit: Array


def recorded(name: str, seed: int, seconds: float = SECONDS) -> Recorded:
    """Record of a kind of rig with hidden numbers drawn by a seed."""
    kind = KINDS[name]
    draw = np.random.default_rng((seed, [*KINDS].index(name), 41))
    spans = {STICKING: (0.65, 0.88), SLIDING: (0.36, 0.5), DECAY: (0.5, 2.0), LOAD: (0.93, 1.07)}
    numbers = {key: draw.uniform(*span) for key, span in spans.items()}
    weight = numbers[LOAD] * INDICATED
    arm = RADIUS * weight
    plain = Machine(
        sticking=numbers[STICKING] * arm, sliding=numbers[SLIDING] * arm, decay=numbers[DECAY], weight=weight
    )
    machine = plain._replace(**kind.machine)
    moved = motion(machine, round(seconds / STEP), _rock(machine.wander, seconds, draw))
    blocks = moved.reshape(-1, round(PERIOD / STEP), 4)
    values = blocks.mean(axis=1) if kind.averaged else blocks[:, -1]
    ends: Array = PERIOD * np.arange(1.0, len(blocks) + 1.0)
    columns = {"torque": _read(kind, values[:, 0], ends), "hookload": np.full(len(blocks), -weight)}
    present = np.ones(ends.size, dtype=bool)
    for start in draw.uniform(10.0, seconds - 10.0, kind.gaps):
        present &= ~((ends > start) & (ends < start + draw.uniform(1.5, 4.0)))
    time = (ends - 0.5 * PERIOD if kind.averaged else ends)[present]
    noisy = with_noise(columns, kind.noise, draw)
    series = {key: (time, column[present]) for key, column in noisy.items()}
    truth = {key: numbers[key] for key in kind.numbers if key.rpartition(".")[2] not in kind.machine}
    for key in {STICKING, SLIDING} & truth.keys():
        truth[key] *= 1.0 + machine.change
    record = Record(f"{name}, seed {seed}", series, instant=frozenset() if kind.averaged else frozenset(series))
    second = round(1.0 / STEP)
    return Recorded(record, truth, moved[second - 1 :: second, 2])


def _rock(size: float, seconds: float, draw: np.random.Generator) -> Array:
    """Factor of the torque at the bit at each step: a random walk that comes back within 10 s."""
    walk = np.zeros(round(seconds) + 2)
    for k in range(1, walk.size):
        walk[k] = walk[k - 1] * np.exp(-0.1) + np.sqrt(1.0 - np.exp(-0.2)) * draw.standard_normal()
    times = STEP * np.arange(round(seconds / STEP))
    return np.asarray(1.0 + size * np.interp(times, np.arange(walk.size), walk))


def _read(kind: Kind, torque: Array, ends: Array) -> Array:
    """Torque as the instrument reads it."""
    late = np.interp(ends - kind.late, ends, torque)
    largest = float(np.abs(late).max())
    clipped = np.clip(late, -kind.most * largest, kind.most * largest)
    return np.asarray((clipped + kind.offset * largest) * (1.0 + kind.drift * ends / ends[-1]))
