# SPDX-License-Identifier: Apache-2.0
"""Hidden truth: a twin with numbers and a seed of its own is measured with noise, and the estimator follows it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from drill_twin.api.scenes import load_scene
from drill_twin.base.arrays import Array
from drill_twin.estimation import LOAD, SENSORS, EnsembleFilter, Estimate, EstimatorOptions, Window
from drill_twin.estimation.members import Members, Prediction
from drill_twin.fitting.ranges import Ranges
from drill_twin.schedule import Schedule

_NOISE = 0.01
"""Standard deviation of a measured sample over the largest value of its channel."""
_SETTLED = 15.0
"""Time from which bands and errors of virtual sensors are counted [s]."""
WARNING = 0.5
"""Chance of whirl from which the estimator warns."""
_TRUTHS, _OPEN = 10_000, 777
"""Seeds of the truths, and of the open loop."""


@dataclass(frozen=True)
class Case:
    """Scene, its free numbers, and what is measured.

    Attributes:
        scene: Name of the scene.
        ranges: Free numbers; the hidden ones are drawn from the same ranges.
        members: Members by default.
        horizon: Horizon of the chance of whirl [s]; 0 s: none is computed.
        overrides: Changes to the scene.
        channels: What is measured.
    """

    scene: str
    ranges: Ranges
    members: int = 64
    horizon: float = 0.0
    overrides: Mapping[str, float | str] = field(default_factory=dict)
    channels: Sequence[str] = ("torque", "hookload")


_ROD: Ranges = {
    "wall_friction.coefficient": (0.1, 0.4),
    "internal_damping.bending_time": (0.015, 0.07),
    "bit_friction.coefficient": (0.03, 0.2),
    LOAD: (0.75, 1.25),
}
CASES: Mapping[str, Case] = {
    "pa6_bench": Case("pa6_bench", _ROD, horizon=4.0),
    "pa6_calm": Case("pa6_bench", _ROD, horizon=4.0, overrides={"wob": 10.0, "rps": 0.6}),
    "stick_slip": Case(
        "two_mass",
        {
            "bit_torque_stribeck.sticking": (0.7, 0.9),
            "bit_torque_stribeck.decay": (0.4, 1.6),
            "internal_damping.torsion_time": (0.1, 0.4),
            LOAD: (0.9, 1.1),
        },
        overrides={"wob": 55e3},
    ),
    "bha": Case(
        "bha_full_size",
        {"wall_friction.coefficient": (0.1, 0.4), "internal_damping.bending_time": (0.5e-3, 2e-3), LOAD: (0.8, 1.2)},
        members=16,
        overrides={"numerics.elements": 40},
    ),
}
"""Cases by name."""


@dataclass(frozen=True)
class Followed:
    """One truth, followed.

    Attributes:
        hidden: Its numbers [SI] by key.
        estimates: Estimate at the end of each window.
        truth: Virtual sensors of the truth by name, shape (W,) each.
        open_loop: The same of a twin with the numbers in the middle of the ranges, which is not corrected.
        whirls: Whether the truth whirls, shape (W,).
        processor: Processor time of the estimator over the time that it followed.
    """

    hidden: Mapping[str, float]
    estimates: Sequence[Estimate]
    truth: Mapping[str, Array]
    open_loop: Mapping[str, Array]
    whirls: Array
    processor: float

    @property
    def errors(self) -> dict[str, float]:
        """Relative error of each number at the end, by key."""
        return {key: band.mean / self.hidden[key] - 1.0 for key, band in self.estimates[-1].numbers.items()}

    @property
    def held(self) -> dict[str, bool]:
        """Verdict by key: True where the band of a number at the end holds the hidden one, by key."""
        return {key: band.low <= self.hidden[key] <= band.high for key, band in self.estimates[-1].numbers.items()}

    def coverage(self, sensor: str) -> float:
        """Share of the later windows in which the band of a virtual sensor holds the truth; NaN if that is constant."""
        true, late = self.truth[sensor], self._late
        margin = 1e-3 * float(np.abs(true).max(initial=0.0))
        if margin == 0.0:
            return float("nan")
        low, high = (
            np.array([getattr(each.sensors[sensor], end) for each in self.estimates]) for end in ("low", "high")
        )
        return float(np.mean((low - margin <= true)[late] & (true <= high + margin)[late]))

    def error_ratio(self, sensor: str) -> float:
        """Rms error of a virtual sensor in the later windows over that of the open loop."""
        mean = np.array([each.sensors[sensor].mean for each in self.estimates])
        own, other = (
            np.mean((found - self.truth[sensor])[self._late] ** 2) for found in (mean, self.open_loop[sensor])
        )
        return float(np.sqrt(own / other)) if other > 0.0 else float("nan")

    @property
    def onset(self) -> float:
        """Start of the first window in which the truth whirls [s]; NaN if it never does."""
        return self._window * int(np.argmax(self.whirls)) if self.whirls.any() else float("nan")

    @property
    def warned(self) -> float:
        """Time of the first warning [s]; NaN without one."""
        return next((each.time for each in self.estimates if each.chance >= WARNING), float("nan"))

    @property
    def _window(self) -> float:
        return self.estimates[0].time

    @property
    def _late(self) -> Array:
        return np.array([each.time > _SETTLED for each in self.estimates])


def follow(case: Case, number: int, seconds: float, members: int) -> Followed:
    """Follow one truth.

    Args:
        case: The case.
        number: Number of the truth, from 0; its numbers, its seed and the noise follow from it.
        seconds: Time to follow [s].
        members: Members of the ensemble.
    """
    scene = load_scene(case.scene, dict(case.overrides))
    found = EnsembleFilter(
        scene, case.ranges, case.channels, EstimatorOptions(members=members, horizon=case.horizon, seed=number + 1)
    )
    middle = {key: (0.5 * (low + high) * (1.0 - 1e-9), 0.5 * (low + high)) for key, (low, high) in case.ranges.items()}
    truth = Members(scene, case.ranges, 1, found.pace, _TRUTHS + number)
    open_loop = Members(scene, middle, 1, found.pace, _OPEN)
    schedule, draw = Schedule.from_scene(scene), np.random.default_rng([number, 1])
    scale: dict[str, float] = {}
    estimates, true, uncorrected = [], list[Prediction](), list[Prediction]()
    spent = 0.0
    for window in range(round(seconds / found.pace.window)):
        ends = (window * found.pace.frames + np.arange(1, found.pace.frames + 1)) * found.pace.period
        commands = np.array([(schedule.weight_on_bit(end), schedule.rotation(end)) for end in ends.tolist()])
        true.append(truth.advance(commands)[1])
        uncorrected.append(open_loop.advance(commands)[1])
        measured = {}
        for name in case.channels:
            values = true[-1].channels[name][0]
            scale[name] = max(scale.get(name, 0.0), float(np.abs(values).max()))
            measured[name] = values + _NOISE * scale[name] * draw.standard_normal(values.size)
        began = time.process_time()
        estimates.append(found.advance(Window(commands, measured)))
        spent += time.process_time() - began
    return Followed(
        hidden=dict(zip(truth.keys, truth.values[0].tolist(), strict=True)),
        estimates=estimates,
        truth={name: np.array([each.sensors[name][0] for each in true]) for name in SENSORS},
        open_loop={name: np.array([each.sensors[name][0] for each in uncorrected]) for name in SENSORS},
        whirls=np.array([each.whirls[0] for each in true]),
        processor=spent / seconds,
    )
