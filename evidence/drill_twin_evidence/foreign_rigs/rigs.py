# SPDX-License-Identifier: Apache-2.0
"""Foreign rigs, their records, and their hidden numbers where our scene has the same ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin_evidence.foreign_rigs import motion as laws
from drill_twin_evidence.foreign_rigs.motion import EXPONENTIAL, GAUSSIAN, JOINED, KARNOPP, STEP, TANH, Mechanics
from drill_twin_studies.fitting import Record

RADIUS = 0.155575
"""Effective radius of friction at the bit [m]; that of the scene `two_mass`."""
INDICATED = 55e3
"""Weight on bit that the rig indicates [N]."""
SECONDS = 24.0
"""Length of a record [s]."""
PERIOD = 0.1
"""Time from sample to sample [s]."""
SURFACE = ("torque", "top_drive_speed", "hookload")
"""Channels of a record."""
SCENE = "two_mass"
OVERRIDES: Mapping[str, float | str] = {
    "wob": INDICATED,
    "rig.top_drive.proportional_gain": 8000.0,
    "rig.top_drive.integral_gain": 3000.0,
    "rig.top_drive.torque_limit": 60e3,
    "rig.rotation.shape": "ramp",
    "rig.rotation.value": 2.5,
    "rig.rotation.initial": 0.0,
    "rig.rotation.start": 0.0,
    "rig.rotation.duration": 4.0,
    "numerics.step": "2 ms",
    "numerics.frame_rate": 10.0,
}
"""Weight, drive and set-point, which are known of each rig."""
STICKING, SLIDING, DECAY = (f"bit_torque_stribeck.{name}" for name in ("sticking", "sliding", "decay"))
LOAD = "load_factor"
RANGES: Mapping[str, tuple[float, float]] = {STICKING: (0.52, 0.95), SLIDING: (0.3, 0.51), DECAY: (0.2, 40.0)}
"""Free numbers of friction."""
LOADS = (0.9, 1.1)
"""Range of the weight on bit over the indicated one."""


@dataclass(frozen=True)
class Rig:
    """A rig and its instruments.

    Attributes:
        law: Law of friction at the bit.
        zone: Speed of its zone of sticking [rad/s].
        changes: Mechanics that differ from those of the scene.
        offset: Of the torque sensor, over the largest torque.
        averaged: Whether a sample is the mean since the last one; else the value at its time.
        gaps: Number of gaps in the record.
        kept: Whether it is kept back for judging: nothing was chosen by it.
        mild: Whether bands are expected without a warning.
    """

    law: int
    zone: float = 1e-3
    changes: Mapping[str, Any] = field(default_factory=dict)
    offset: float = 0.0
    averaged: bool = True
    gaps: int = 0
    kept: bool = False
    mild: bool = False


_STRING = {"string_inertia": 140.0, "springs": 12}
RIGS: Mapping[str, Rig] = {
    "mild exponential": Rig(EXPONENTIAL, mild=True),
    "mild tanh": Rig(TANH, zone=0.02, mild=True),
    "gaussian, drive lag": Rig(GAUSSIAN, changes={"lag": 0.3}),
    "karnopp, instantaneous": Rig(KARNOPP, zone=0.05, averaged=False),
    "joined, distributed, gaps": Rig(JOINED, changes=_STRING, gaps=3),
    "tanh, offset, instantaneous": Rig(TANH, zone=0.1, offset=0.02, averaged=False),
    "karnopp, distributed, lag": Rig(KARNOPP, zone=0.02, changes=_STRING | {"lag": 0.15}, kept=True),
    "gaussian, offset, gaps": Rig(GAUSSIAN, offset=0.02, gaps=2, averaged=False, kept=True),
    "mild joined": Rig(JOINED, kept=True, mild=True),
    "tanh, stiff string": Rig(TANH, zone=0.05, changes={"stiffness": 1.15 * 861.5336}, kept=True),
}
"""Rigs by name."""


@dataclass(frozen=True)
class Trial:
    """A record and what is true of it.

    Attributes:
        record: Torque, speed of the drive, hookload.
        truth: Hidden numbers by key of the scene [SI]; none where the law has no such number.
        bit: Time [s] and speed of the bit [rad/s], every 10 ms, shape (T,) each.
        mechanics: The rig.
        present: Samples that the record has, of all, shape (S,).
    """

    record: Record
    truth: Mapping[str, float]
    bit: tuple[Array, Array]
    mechanics: Mechanics
    present: Mask


def strongest(rig: Mechanics) -> float:
    """Largest torque of friction over all speeds [N m]: what breaks the bit off."""
    if rig.law != TANH:
        return rig.sticking
    speed = np.linspace(0.0, 5.0, 20_001)
    return float(max(laws.friction(rig, one) * np.tanh(one / rig.zone) for one in speed.tolist()))


def sampled(
    rig: Rig, mechanics: Mechanics, weight: float, step: float = STEP, seconds: float = SECONDS
) -> tuple[Array, dict[str, Array], Array]:
    """Times of the samples [s], channels without noise, and speed of the bit every step [rad/s]."""
    every = round(PERIOD / step)
    steps: Array = laws.motion(mechanics, round(seconds / PERIOD) * every, step)
    blocks = steps.reshape(-1, every, 4)
    values = blocks.mean(axis=1) if rig.averaged else blocks[:, -1]
    columns = {
        "torque": values[:, 0] + rig.offset * np.abs(values[:, 0]).max(),
        "top_drive_speed": values[:, 1],
        "hookload": np.full(len(values), -weight),
        "bit_speed": values[:, 2],
    }
    ends: Array = PERIOD * np.arange(1.0, len(blocks) + 1.0)
    return ends - 0.5 * PERIOD if rig.averaged else ends, columns, steps[:, 2]


def mechanics_of(rig: Rig, numbers: Mapping[str, float]) -> Mechanics:
    """A rig with friction and load by key [SI]."""
    arm = RADIUS * numbers[LOAD] * INDICATED
    plain = Mechanics(rig.law, numbers[STICKING] * arm, numbers[SLIDING] * arm, numbers[DECAY], rig.zone)
    return plain._replace(**rig.changes)


def with_noise(columns: Mapping[str, Array], noise: float, generator: np.random.Generator) -> dict[str, Array]:
    """Channels with white noise, a share of the largest value of each."""
    return {
        key: column + noise * np.abs(column).max() * generator.standard_normal(column.size)
        for key, column in columns.items()
    }


def trial(name: str, seed: int, noise: float = 0.01, seconds: float = SECONDS) -> Trial:
    """Record of a rig with hidden numbers drawn by a seed; the noise is a share of the largest value of a channel."""
    rig = RIGS[name]
    generator = np.random.default_rng((seed, [*RIGS].index(name), 32))
    spans = {STICKING: (0.65, 0.88), SLIDING: (0.36, 0.5), DECAY: (0.5, 2.0), LOAD: (0.93, 1.07)}
    numbers = {key: generator.uniform(*span) for key, span in spans.items()}
    mechanics, weight = mechanics_of(rig, numbers), numbers[LOAD] * INDICATED
    time, columns, bit = sampled(rig, mechanics, weight, seconds=seconds)
    noisy = with_noise({key: columns[key] for key in SURFACE}, noise, generator)
    present = np.ones(time.size, dtype=bool)
    for start in generator.uniform(5.0, seconds - 6.0, rig.gaps):
        present &= ~((time > start) & (time < start + generator.uniform(1.5, 4.0)))
    series = {key: (time[present], column[present]) for key, column in noisy.items()}
    truth = numbers | {STICKING: strongest(mechanics) / (RADIUS * weight)}
    if rig.law != EXPONENTIAL:
        del truth[DECAY]
    fine = round(0.01 / STEP)
    places: Array = 0.01 * np.arange(1.0, len(bit) // fine + 1.0)
    record = Record(f"{name}, seed {seed}", series, instant=frozenset() if rig.averaged else frozenset(series))
    return Trial(record, truth, (places, bit[fine - 1 :: fine]), mechanics, present)
