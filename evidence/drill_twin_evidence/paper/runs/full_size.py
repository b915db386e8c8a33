# SPDX-License-Identifier: Apache-2.0
"""The full-size bottom-hole assembly of the paper's section 4, with assumed dimensions: its Table 4 is lost."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drill_twin.scene import Scene, load_scene
from drill_twin_evidence.paper.runs.cases import Case, scene_of
from drill_twin_evidence.paper.runs.disorder import largest_lyapunov, spectral_entropy
from drill_twin_evidence.paper.runs.published import Range, published
from drill_twin_evidence.paper.runs.run import Run
from drill_twin_evidence.paper.runs.table import NEAR

RPM = 1.0 / 60.0
REFERENCE = Case(160e3, 50 * RPM)
LOADS = tuple(Case(load, 50 * RPM) for load in (100e3, 150e3, 200e3))
SPEEDS = tuple(Case(180e3, speed * RPM) for speed in (40, 60, 80, 100))
CASES = (REFERENCE, *LOADS, *SPEEDS)
NEAR_BIT, FAR_BIT = "near_bit", "far_bit"
STEADY_SHARE = 0.95
"""Steady rotation: the near-bit mark rotates at this share of the final speed of the top drive."""
RECORD_LENGTH = 6.0
"""Length of the last part of each run, whose disorder is compared [s]."""


@dataclass(frozen=True)
class FullSizeRow:
    """A published value or range of the full-size assembly, and that of the twin."""

    number: Range
    ours: tuple[float, float] | None
    """Lowest and highest, equal for a single value; None where there is none."""

    @property
    def near(self) -> bool:
        """True if both ends are within 20 %."""
        ends = ((self.number.low, self.number.high), self.ours or (math.inf, math.inf))
        return all(abs(ours - value) <= NEAR * abs(value) for value, ours in zip(*ends, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {**asdict(self.number), "ours": self.ours, "near": self.near}


@dataclass(frozen=True)
class Disorder:
    """Disorder of the motion at one speed."""

    speed: float
    """[r/min]"""
    entropy: float
    """Spectral entropy of the near-bit orbit, 0 to 1."""
    lyapunov: float
    """Largest Lyapunov exponent [1/s]."""
    per_turn: float
    """Largest Lyapunov exponent per revolution [-]."""


def scenes(name: str = "bha_full_size") -> dict[Case, Scene]:
    """Scenes of the runs of section 4."""
    scene = load_scene(name)
    return {case: scene_of(scene, case) for case in CASES}


def rows(runs: Mapping[Case, Run]) -> list[FullSizeRow]:
    """Published numbers and those of the twin, for the runs available."""
    found: dict[str, tuple[float, float] | None] = {}
    if REFERENCE in runs:
        run = runs[REFERENCE]
        steady, onset = steady_from(run), run.summary.onset_s
        found["steady rotation from"] = _single(steady)
        found["lateral vibration from"] = _single(onset)
        before = (run.time >= (steady or 0.0)) & (run.time < (math.inf if onset is None else onset))
        after = run.time >= (math.inf if onset is None else onset)
        for mark, word in ((NEAR_BIT, "near-bit"), (FAR_BIT, "far-bit")):
            found[f"{word} velocity before whirl"] = _range(run.velocity[before, run.index(mark), :2])
            found[f"{word} velocity in whirl"] = _range(run.velocity[after, run.index(mark), :2])
    for case in LOADS:
        if case in runs:
            run = runs[case]
            place = run.point[:, run.index(NEAR_BIT), :2] * 1e3
            found[f"near-bit displacement at {case.weight_on_bit * 1e-3:g} kN"] = _range(place)
    return [FullSizeRow(number, found.get(number.what)) for number in published().full_size]


def steady_from(run: Run) -> float | None:
    """Time at which the near-bit mark first reaches steady rotation [s]."""
    rate = run.spin_rate[:, run.index(NEAR_BIT)]
    target = run.summary.rotation_rev_s
    if target is None:
        return None
    turning = np.flatnonzero(rate >= STEADY_SHARE * abs(target) * math.tau)
    return float(run.time[turning[0]]) if turning.size else None


def disorder(case: Case, scene: Scene, run: Run) -> Disorder:
    """Disorder of the last seconds of a run; makes two more runs for the exponent."""
    late = run.time > run.time[-1] - RECORD_LENGTH
    centre = run.centre[late, run.index(NEAR_BIT)]
    exponent = largest_lyapunov(scene, float(run.time[-1]) - RECORD_LENGTH, RECORD_LENGTH)
    entropy = spectral_entropy(run.time[late], centre[:, 0] + 1j * centre[:, 1])
    return Disorder(case.speed / RPM, entropy, exponent, exponent / case.speed)


def _single(value: float | None) -> tuple[float, float] | None:
    return None if value is None else (value, value)


def _range(values: np.ndarray) -> tuple[float, float] | None:
    return (float(values.min()), float(values.max())) if values.size else None
