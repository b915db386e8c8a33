# SPDX-License-Identifier: Apache-2.0
"""Hidden truth: a twin with numbers and a seed of its own is measured with noise, and the estimator follows it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from drill_twin.api.scenes import load_scene
from drill_twin.core.arrays import Array
from drill_twin.dynamics.sensors.sampling import errors_of, with_errors
from drill_twin.scene.blocks.sensors import Sub
from drill_twin.scene.set_points import Schedule
from drill_twin.studies.estimation import LOAD, EnsembleFilter, Estimate, EstimatorOptions, FilterWindow
from drill_twin.studies.estimation.members import EstimatorMembers
from drill_twin.studies.estimation.prediction import Prediction
from drill_twin.studies.fitting.sampling import Ranges

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
        imu: A downhole sub, measured too if asked for, as in a scene's `sensors`.
    """

    scene: str
    ranges: Ranges
    members: int = 64
    horizon: float = 0.0
    overrides: Mapping[str, float | str] = field(default_factory=dict)
    channels: Sequence[str] = ("torque", "hookload")
    imu: str = ""


_ERRORS = "accelerometer: {noise: 5 mm/s^2, bias: 0.05 m/s^2}, gyroscope: {noise: 0.06 deg/s, bias: 0.3 deg/s}"
_NEAR_BIT = f"name: near_bit, distance_from_bit: 1 m, radius: 6 mm, rate: 100 Hz, {_ERRORS}"
_ROD: Ranges = {
    "wall_friction.coefficient": (0.1, 0.4),
    "internal_damping.bending_time": (0.015, 0.07),
    "bit_friction.coefficient": (0.03, 0.2),
    LOAD: (0.75, 1.25),
}
CASES: Mapping[str, Case] = {
    "pa6_bench": Case("pa6_bench", _ROD, horizon=4.0, imu=_NEAR_BIT),
    "pa6_calm": Case("pa6_bench", _ROD, horizon=4.0, overrides={"wob": 10.0, "rps": 0.6}, imu=_NEAR_BIT),
    "stick_slip": Case(
        "two_mass",
        {
            "bit_torque_stribeck.sticking": (0.7, 0.9),
            "bit_torque_stribeck.decay": (0.4, 1.6),
            "internal_damping.torsion_time": (0.1, 0.4),
            LOAD: (0.9, 1.1),
        },
        overrides={"wob": 55e3},
        imu=f"name: near_bit, distance_from_bit: 0.05 m, rate: 50 Hz, {_ERRORS}",
    ),
    "bha": Case(
        "bha_full_size",
        {"wall_friction.coefficient": (0.1, 0.4), "internal_damping.bending_time": (0.5e-3, 2e-3), LOAD: (0.8, 1.2)},
        members=16,
        overrides={"numerics.elements": 40},
        imu=f"name: near_bit, distance_from_bit: 15 m, radius: 80 mm, rate: 100 Hz, {_ERRORS}",
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
    def warnings(self) -> list[float]:
        """Times of all windows that warn of whirl [s]."""
        return [each.time for each in self.estimates if each.chance >= WARNING]

    @property
    def _window(self) -> float:
        return self.estimates[0].time

    @property
    def _late(self) -> Array:
        return np.array([each.time > _SETTLED for each in self.estimates])


def follow(case: Case, number: int, seconds: float, members: int, *, imu: bool = False) -> Followed:
    """Follow one truth.

    Args:
        case: The case.
        number: Number of the truth, from 0; its numbers, its seed and the noise follow from it.
        seconds: Time to follow [s].
        members: Members of the ensemble.
        imu: Measure the downhole sub of the case too.
    """
    scene = load_scene(case.scene, dict(case.overrides) | ({"sensors": f"{{subs: [{{{case.imu}}}]}}"} if imu else {}))
    subs = [sub.name for sub in scene.sensors.subs] if scene.sensors is not None else []
    options = EstimatorOptions(members=members, horizon=case.horizon, seed=number + 1)
    found = EnsembleFilter(scene, case.ranges, case.channels, options, subs)
    middle = {key: (0.5 * (low + high) * (1.0 - 1e-9), 0.5 * (low + high)) for key, (low, high) in case.ranges.items()}
    truth, open_loop = (
        EstimatorMembers(scene, ranges, 1, found.pace, seed, subs)
        for ranges, seed in ((case.ranges, _TRUTHS + number), (middle, _OPEN))
    )
    tools = [Tool(sub, number) for sub in truth.subs]
    sensors: dict[EstimatorMembers, list[dict[str, float]]] = {truth: [], open_loop: []}
    schedule, draw = Schedule.from_scene(scene), np.random.default_rng([number, 1])
    scale: dict[str, float] = {}
    estimates, whirls = [], []
    spent = 0.0
    for window in range(round(seconds / found.pace.window)):
        ends = (window * found.pace.frames + np.arange(1, found.pace.frames + 1)) * found.pace.period
        commands = np.array([schedule.at(end).array() for end in ends.tolist()])
        true = _advance(truth, commands, sensors[truth])
        _advance(open_loop, commands, sensors[open_loop])
        whirls.append(bool(true.whirls[0]))
        measured = {}
        for name in case.channels:
            values = true.channels[name][0]
            scale[name] = max(scale.get(name, 0.0), float(np.abs(values).max()))
            measured[name] = values + _NOISE * scale[name] * draw.standard_normal(values.size)
        readings = np.array([tool(true.readings[0, :, k]) for k, tool in enumerate(tools)])
        began = time.process_time()
        estimates.append(found.advance(FilterWindow(commands, measured, readings if tools else None)))
        spent += time.process_time() - began
    return Followed(
        hidden=dict(zip(truth.keys, truth.values[0].tolist(), strict=True)),
        estimates=estimates,
        truth=_columns(sensors[truth]),
        open_loop=_columns(sensors[open_loop]),
        whirls=np.array(whirls),
        processor=spent / seconds,
    )


class Tool:
    """Readings of a sub, with its errors."""

    def __init__(self, sub: Sub, seed: int) -> None:
        self._errors = errors_of((*[sub.accelerometer] * 3, *[sub.gyroscope] * 3), seed, 0)
        self._draw = np.random.default_rng([seed, 2])

    def __call__(self, true: Array) -> Array:
        """Readings of true means, both of shape (F, 6)."""
        return with_errors(true, self._draw.standard_normal(true.shape), self._errors)


def _advance(one: EstimatorMembers, commands: Array, sensors: list[dict[str, float]]) -> Prediction:
    """Advance a twin by a window, and add its virtual sensors, those of `Estimate.sensors`."""
    prediction = one.advance(commands)[1]
    sensors.append(
        {name: float(values[0]) for name, values in prediction.sensors.items()}
        | {name: float(values[0]) for name, values in one.places.items()}
    )
    return prediction


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, Array]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
