# SPDX-License-Identifier: Apache-2.0
"""Hidden truth: a twin with numbers and a seed of its own is measured with noise, and the estimator follows it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special
from typing_extensions import TypedDict

from drill_twin.api.scenes import load_scene
from drill_twin.core.arrays import Array, Mask
from drill_twin.core.rig_channels import INSTANT
from drill_twin.dynamics.sensors.sampling import errors_of, with_errors
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.blocks.sensors import Sub
from drill_twin.scene.load import override
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.estimation.cases import JUMP, SIZES, STIFFNESS, TOLERANCES, Case
from drill_twin_evidence.estimation.stamps import USUAL, Stamps
from drill_twin_studies.api.estimator import Estimator
from drill_twin_studies.estimation import Estimate, EstimatorOptions
from drill_twin_studies.estimation.estimate import FilterWindow, Prediction, WindowTiming
from drill_twin_studies.estimation.members import EstimatorMembers
from drill_twin_studies.estimation.subs import VALUES

_NOISE = 0.01
"""Standard deviation of a measured sample over the largest value of its channel."""
_SETTLED = 15.0
"""Time from which bands and errors of virtual sensors are counted [s]."""
_FRAME = 5e-3
"""Longest frame of a truth [s], of which its samples are means: short against the time between those at 100 Hz."""
_MEANS = {"weight_on_bit": "bit_force", "bit_torque": "bit_torque"}
"""Virtual sensors that are means over a frame, and the names of their channels."""
WARNING = 0.5
"""Chance of whirl from which the estimator warns."""
_TRUTHS, _OPEN = 10_000, 777
"""Seeds of the truths, and of the open loop."""


class TruthRow(TypedDict):
    """One truth, followed, in plain types; times in s. It is told if an alarm stands at the end."""

    case: str
    members: int
    truth: int
    seconds: float
    errors: dict[str, float]
    held: dict[str, bool]
    coverage: dict[str, float]
    shown: dict[str, float]
    error_ratio: dict[str, float]
    onset: float
    warnings: list[float]
    alarms: list[float]
    withheld: float
    told: bool
    followed: dict[str, float]
    dragged: dict[str, tuple[float, float]]
    processor: float


@dataclass(frozen=True)
class Followed:
    """One truth, followed.

    Attributes:
        before, hidden: Its numbers [SI] by key, before a jump and at the end.
        estimates: Estimate at the end of each window.
        truth: Virtual sensors of the truth by name, shape (W,) each.
        open_loop: The same of a twin with the numbers in the middle of the ranges, which is not corrected.
        whirls: Whether the truth whirls, shape (W,).
        processor: Processor time of the estimator over the time that it followed.
        jumped: Whether a number has jumped.
    """

    before: Mapping[str, float]
    hidden: Mapping[str, float]
    estimates: Sequence[Estimate]
    truth: Mapping[str, Array]
    open_loop: Mapping[str, Array]
    whirls: Array
    processor: float
    jumped: bool

    @property
    def errors(self) -> dict[str, float]:
        """Relative error of each number at the end, by key."""
        return {key: band.mean / self.hidden[key] - 1.0 for key, band in self.estimates[-1].numbers.items()}

    @property
    def held(self) -> dict[str, bool]:
        """Verdict by key: True where the band of a number at the end holds the hidden one, by key."""
        return {key: band.low <= self.hidden[key] <= band.high for key, band in self.estimates[-1].numbers.items()}

    def coverage(self, sensor: str) -> float:
        """Share of the later windows in which the band of a virtual sensor holds the truth, of those that have one.

        NaN if there is none, or the truth is constant.
        """
        true, late = self.truth[sensor], self._late & self._shown(sensor)
        margin = 1e-3 * float(np.abs(true).max(initial=0.0))
        if margin == 0.0 or not late.any():
            return float("nan")
        low, high = (
            np.array([getattr(each.sensors[sensor], end) for each in self.estimates]) for end in ("low", "high")
        )
        return float(np.mean((low - margin <= true)[late] & (true <= high + margin)[late]))

    @property
    def withheld(self) -> float:
        """Share of the later windows in which the speed of the bit is withheld."""
        return 1.0 - self.shown("bit_speed")

    def error_ratio(self, sensor: str) -> float:
        """Rms error of a virtual sensor in the later windows over that of the open loop."""
        mean = np.array([each.sensors[sensor].mean for each in self.estimates])
        late = self._late & np.isfinite(mean)
        if not late.any():
            return float("nan")
        own, other = (np.mean((found - self.truth[sensor])[late] ** 2) for found in (mean, self.open_loop[sensor]))
        return float(np.sqrt(own / other)) if other > 0.0 else float("nan")

    def shown(self, sensor: str) -> float:
        """Share of the later windows in which the band of a virtual sensor is not withheld."""
        return float(self._shown(sensor)[self._late].mean())

    def _shown(self, sensor: str) -> Mask:
        return np.isfinite([each.sensors[sensor].low for each in self.estimates])

    @property
    def onset(self) -> float:
        """Start of the first window in which the truth whirls [s]; NaN if it never does."""
        return self._window * int(np.argmax(self.whirls)) if self.whirls.any() else float("nan")

    @property
    def warnings(self) -> list[float]:
        """Times of all windows that warn of whirl [s]."""
        return [each.time for each in self.estimates if each.chance >= WARNING]

    @property
    def alarms(self) -> list[float]:
        """Times at which an alarm begins [s]."""
        told = [bool(each.alarm) for each in self.estimates]
        return [each.time for each, now, then in zip(self.estimates, told, [False, *told], strict=False) if now > then]

    def found_after(self, key: str, tolerance: float) -> float:
        """Time from the jump from which the mean of a number stays within a relative tolerance of the new one [s]."""
        off = [each.time for each in self.estimates if abs(each.numbers[key].mean / self.hidden[key] - 1.0) > tolerance]
        return max([0.0, *(time - JUMP for time in off)])

    def dragged(self, key: str) -> tuple[float, float]:
        """Relative change of the mean of a number since the jump: the largest one, and that at the end."""
        means = [each.numbers[key].mean for each in self.estimates]
        start = round(JUMP / self._window)
        changes = [abs(mean / means[start - 1] - 1.0) for mean in means[start:]]
        return max(changes), changes[-1]

    def row(self, case: str, members: int, truth: int) -> TruthRow:
        """Plain types that the score needs of it.

        Args:
            case: Name of the case.
            members: Members of the ensemble.
            truth: Number of the truth.
        """
        changed = [key for key, value in self.hidden.items() if value != self.before[key]]
        return TruthRow(
            case=case,
            members=members,
            truth=truth,
            seconds=self.estimates[-1].time,
            errors=self.errors,
            held=self.held,
            coverage={name: self.coverage(name) for name in self.truth},
            shown={name: self.shown(name) for name in self.truth},
            error_ratio={name: self.error_ratio(name) for name in self.truth},
            onset=self.onset,
            warnings=self.warnings,
            alarms=self.alarms,
            withheld=self.withheld,
            told=bool(self.estimates[-1].alarm),
            followed={key: self.found_after(key, TOLERANCES.get(key, 0.05)) for key in changed},
            dragged={key: self.dragged(key) for key in self.hidden if key not in changed} if self.jumped else {},
            processor=self.processor,
        )

    @property
    def _window(self) -> float:
        return self.estimates[0].time

    @property
    def _late(self) -> Mask:
        return np.array([each.time > _SETTLED for each in self.estimates])


def follow(
    case: Case, number: int, seconds: float, members: int, *, imu: bool = False, stamps: Stamps = USUAL
) -> Followed:
    """Follow one truth.

    Args:
        case: The case.
        number: Number of the truth, from 0; its numbers, its seed, the noise and the stamps follow from it.
        seconds: Time to follow [s].
        members: Members of the ensemble.
        imu: Measure the downhole sub of the case too.
        stamps: How the surface is sampled.
    """
    scene = load_scene(case.scene, dict(case.overrides) | ({"sensors": f"{{subs: [{{{case.imu}}}]}}"} if imu else {}))
    subs = [sub.name for sub in scene.sensors.subs] if scene.sensors is not None else []
    options = EstimatorOptions(members=members, horizon=case.horizon, seed=number + 1)
    names = [f"{name}{INSTANT}" if stamps.instant else name for name in case.channels]
    found = Estimator(scene, case.ranges, channels=names, subs=subs, options=options)
    middle = {key: (0.5 * (low + high) * (1.0 - 1e-9), 0.5 * (low + high)) for key, (low, high) in case.ranges.items()}
    record = stamps.drawn(number)
    pace, fine = found.filter.pace, math.ceil(found.filter.pace.period / _FRAME)
    own = WindowTiming(pace.period / fine / record.clock, pace.frames * fine, pace.samples)
    truth, open_loop = (
        EstimatorMembers(scene, ranges, 1, own, seed, subs, [*names, *_MEANS.values()])
        for ranges, seed in ((case.ranges, _TRUTHS + number), (middle, _OPEN))
    )
    for key, (low, high) in (case.truths or {}).items():
        _set(truth, case, key, low + (high - low) * special.ndtr(truth.normal[0, truth.keys.index(key)]))
    before = _numbers(truth)
    tools = [Tool(sub, number) for sub in truth.subs]
    sensors: dict[EstimatorMembers, list[dict[str, float]]] = {truth: [], open_loop: []}
    schedule, draw = Schedule.from_scene(scene), np.random.default_rng([number, 1])
    scale: dict[str, float] = {}
    estimates: list[Estimate] = []
    whirls: list[bool] = []
    spent = 0.0
    found.take(0.0)
    while len(estimates) < round(seconds / pace.window):
        window = len(whirls)
        ends = (window * own.frames + np.arange(1, own.frames + 1)) * pace.period / fine
        commands = schedule.over(ends.tolist())
        if case.jump and window == round(JUMP / pace.window):
            _jump(truth, case, number)
        true = _advance(truth, commands, fine, sensors[truth])
        _advance(open_loop, commands, fine, sensors[open_loop])
        whirls.append(bool(true.whirls[0]))
        record.add({name: true.channels[name][0] for name in names}, own.period)
        readings = true.readings[0].reshape(pace.frames, fine, len(subs), VALUES).mean(axis=1)
        for k, (name, tool) in enumerate(zip(subs, tools, strict=True)):
            for place, values in enumerate(tool(readings[:, k])):
                found.take_readings((window * pace.frames + place + 0.5) * pace.period, name, values)
        for stamp, values in record.samples():
            noisy = {}
            for name, value in values.items():
                scale[name] = max(scale.get(name, 0.0), abs(value))
                noisy[name.removesuffix(INSTANT)] = value + _NOISE * scale[name] * float(draw.standard_normal())
            began = time.process_time()
            found.take(stamp, noisy)
            while (estimate := found.step()) is not None:
                estimates.append(estimate)
            spent += time.process_time() - began
    count = round(seconds / pace.window)
    return Followed(
        before=before,
        hidden=_numbers(truth),
        estimates=estimates[:count],
        truth=_columns(sensors[truth][:count]),
        open_loop=_columns(sensors[open_loop][:count]),
        whirls=np.array(whirls[:count]),
        processor=spent / (len(estimates) * pace.window),
        jumped=bool(case.jump),
    )


def _numbers(truth: EstimatorMembers) -> dict[str, float]:
    return dict(zip(truth.keys, truth.values[0].tolist(), strict=True))


def _set(truth: EstimatorMembers, case: Case, key: str, value: float) -> None:
    """Give a truth another number, within its range."""
    low, high = case.ranges[key]
    truth.normal[0, truth.keys.index(key)] = special.ndtri((value - low) / (high - low))
    truth.correct([])


def _jump(truth: EstimatorMembers, case: Case, number: int) -> None:
    """Let the numbers of a case jump: free ones, or one of the string, whose twin goes on from the same state."""
    draw = np.random.default_rng([number, 3])
    factor = 1.0 + float(draw.choice([-1.0, 1.0]) * draw.uniform(*SIZES))
    if case.jump != STIFFNESS:
        for key in case.jump.split():
            low, high = case.ranges[key]
            edge = 1e-3 * (high - low)
            _set(truth, case, key, min(max(factor * _numbers(truth)[key], low + edge), high - edge))
        return
    old = truth.twins[0]
    changed = {STIFFNESS: factor * old.scene.string.sections[0].youngs_modulus}
    truth.twins[0] = Twin(override(old.scene, changed))
    truth.twins[0].restore(old.checkpoint())


class Tool:
    """Readings of a sub, with its errors."""

    def __init__(self, sub: Sub, seed: int) -> None:
        self._errors = errors_of((*[sub.accelerometer] * 3, *[sub.gyroscope] * 3), seed, 0)
        self._draw = np.random.default_rng([seed, 2])

    def __call__(self, true: Array) -> Array:
        """Readings of true means, both of shape (F, 6)."""
        return with_errors(true, self._draw.standard_normal(true.shape), self._errors)


def _advance(one: EstimatorMembers, commands: Array, fine: int, sensors: list[dict[str, float]]) -> Prediction:
    """Advance a twin by a window, and add its virtual sensors, those of `Estimate.sensors`; channels are its frames.

    Forces are means over a frame of the estimator, which has a number of those of the twin.
    """
    frames = np.vstack((np.zeros((one.pace.tail, len(commands))), np.eye(len(commands))))
    prediction = one.advance(FilterWindow(commands, {}, np.array([frames] * len(one.channels))))[1]
    sensors.append(
        {name: float(values[0]) for name, values in prediction.sensors.items()}
        | {name: float(values[0]) for name, values in one.places.items()}
        | {name: float(prediction.channels[channel][0, -fine:].mean()) for name, channel in _MEANS.items()}
    )
    return prediction


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, Array]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
