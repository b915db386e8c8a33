# SPDX-License-Identifier: Apache-2.0
"""Estimator for Python: samples of a rig in, estimates out (docs/drill_twin_studies/estimator.md)."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from numbers import Real
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.api.scenes import GivenRange, Overrides, as_scene, range_of
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, SceneError, nearest
from drill_twin.core.rig_channels import INSTANT
from drill_twin.core.units.ranges import parse_range
from drill_twin.scene import Scene
from drill_twin_studies.estimation import CHANNELS, LOAD, SET_POINTS, EnsembleFilter, Estimate, EstimatorOptions, Intake
from drill_twin_studies.estimation.subs import VALUES
from drill_twin_studies.fitting import Record

_AHEAD = 0.5  # s, by which readings are taken before the samples of the surface that close their window


class Estimator:
    """An ensemble that follows a rig; state in, state out, no clock of its own.

    >>> estimator = Estimator("pa6_bench", {"wall_friction.coefficient": "0.1..0.4", "load_factor": "0.8..1.2"})
    >>> estimator.take(stamp, {"torque": 0.9, "hookload": 31.0, "weight_on_bit": 40.0, "rotation": 12.6})
    >>> while (estimate := estimator.step()) is not None:
    ...     print(estimate.time, estimate.numbers["load_factor"].mean, estimate.alarm)

    Attributes:
        scene: The scene.
        channels: Channels of the surface that correct.
        intake: Samples on their way to windows; has the troubles with them.
        filter: The ensemble.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        free: Mapping[str, str | tuple[float, float]],
        *,
        channels: Sequence[str] = ("torque", "hookload"),
        subs: str | Sequence[str] = (),
        overrides: Overrides | None = None,
        options: EstimatorOptions | None = None,
    ) -> None:
        """Make the ensemble.

        Args:
            scene: The scene.
            free: Range of each free number by key, as of `fit`: numbers of effects and of `rig.top_drive`, and
                `load_factor`, weight on bit over the commanded or indicated weight.
            channels: Channels that correct: torque, motor_torque (with inertia and bearings of the drive), hookload,
                top_drive_speed, bit_speed. A sample is a mean since the last sample; of "torque@instant", a
                value at its time.
            subs: Downhole subs whose readings correct, by their names in the scene's `sensors`; a sub of a real rig may
                be `measured/NAME`.
            overrides: Values that replace the scene's values.
            options: Members, windows, errors, horizon.

        Raises:
            ArgumentError: A channel, a number or a sub that cannot be taken.
            SceneError: A range does not fit the scene.
        """
        self.scene = as_scene(scene, overrides)
        instant = frozenset(name.removesuffix(INSTANT) for name in map(str, channels) if name.endswith(INSTANT))
        channels = [str(name).removesuffix(INSTANT) for name in channels] if instant else channels
        _check(channels, free)
        self.channels = tuple(channels)
        ranges = {key: _ends(given) if key == LOAD else _range(self.scene, key, free) for key, given in free.items()}
        subs = (subs,) if isinstance(subs, str) else tuple(subs)
        self.filter = EnsembleFilter(self.scene, ranges, channels, options or EstimatorOptions(), subs, instant)
        self.intake = Intake(self.filter.pace, self.scene, channels, self.filter.members.subs, instant)
        self._subs = {name: number for number, name in enumerate(subs)}

    def take(self, stamp: float, values: Mapping[str, float] = {}) -> bool:
        """Take a sample; returns False for a stamp that cannot be used: late, repeated or not finite.

        Args:
            stamp: Time of the sample [s], of any clock.
            values: Channels, `weight_on_bit` [N] and `rotation` [rad/s] by name; NaN where there is none. Set-points
                that never come are the scene's. Without values, time passes, and the ensemble runs alone.

        Raises:
            ArgumentError: A name is no channel and no set-point, or a value is no number.
        """
        if not isinstance(values, Mapping) or not all(isinstance(one, Real) for one in (stamp, *values.values())):
            raise ArgumentError(
                f'expected a time [s] and numbers by name, as take(0.1, {{"torque": 1e3}}), found {stamp!r} and '
                f"{values!r}"
            )
        if odd := sorted(map(str, values.keys() - {*CHANNELS, *SET_POINTS})):
            raise ArgumentError(f"expected one of {', '.join((*CHANNELS, *SET_POINTS))}, found {', '.join(odd)}")
        return self.intake.take(stamp, values)

    def take_readings(self, stamp: float, sub: str, values: Sequence[float] | Array) -> None:
        """Take a reading of a downhole sub.

        Args:
            stamp: Its time [s], of the same clock as the stamps of samples; a reading before the first sample is left
                out.
            sub: Name of the sub, as it was given.
            values: Specific force [m/s^2] and rates of rotation [rad/s] in the axes of the sub (docs/sensors.md), six.

        Raises:
            ArgumentError: Another sub, or no six numbers.
        """
        if sub not in self._subs or np.shape(values) != (VALUES,) or not isinstance(stamp, Real):
            raise ArgumentError(
                f"expected a time [s], a sub of {', '.join(self._subs) or 'none'} and {VALUES} numbers, "
                f"found {stamp!r}, {sub!r} and {values!r}"
            )
        self.intake.take_readings(float(stamp), self._subs[sub], values)

    def step(self) -> Estimate | None:
        """Estimate at the end of the next whole window; None while there is none.

        Raises:
            RunError: No member could be followed.
        """
        window = self.intake.window()
        return None if window is None else self.filter.advance(window)

    def follow(self, record: Record) -> Iterator[Estimate]:
        """Estimates over a record from its time zero on, with the readings of the subs that it has."""
        samples: dict[float, dict[str, float]] = {}
        for name, (time, values) in record.series.items():
            at_end = name in (*SET_POINTS, *record.ends, *record.instant)
            ends = time if at_end else time + 0.5 * float(np.median(np.diff(time)))
            for stamp, value in zip(np.round(np.maximum(ends, 0.0), 6).tolist(), values.tolist(), strict=True):
                samples.setdefault(stamp, {})[name] = value  # of what is before zero, the last set-point is held
        first = {name: value for name, value in samples.pop(0.0, {}).items() if name in SET_POINTS}
        self.take(0.0, first)
        readings = deque(sorted(_readings(record, self._subs), key=itemgetter(0)))
        for stamp in sorted(samples):
            while readings and readings[0][0] <= stamp + _AHEAD:
                self.take_readings(*readings.popleft())
            self.take(stamp, samples[stamp])
            while (found := self.step()) is not None:
                yield found


def _readings(record: Record, subs: Iterable[str]) -> Iterator[tuple[float, str, Array]]:
    for name in subs:
        if name not in record.subs:
            raise ArgumentError(
                f"{record.source}: expected readings of {name}, found {', '.join(record.subs) or 'none'}"
            )
        yield from (
            (time, name, values)
            for time, values in zip(record.subs[name][0].tolist(), record.subs[name][1], strict=True)
        )


def _check(channels: Sequence[str], free: Mapping[str, Any]) -> None:
    """Refuse channels and free numbers that are none, unknown or given twice."""
    if isinstance(channels, str) or not isinstance(free, Mapping):
        raise ArgumentError(
            'expected a list of channels, as ["torque", "hookload"], and ranges by key, as '
            f'{{"{LOAD}": "0.8..1.2"}}, found {channels!r} and {free!r}'
        )
    odd = [str(name) for name in channels if name not in CHANNELS]
    twice = [name for name in CHANNELS if channels.count(name) > 1]
    if odd or twice or not channels or not free:
        raise ArgumentError(
            f"expected channels of {', '.join(CHANNELS)}, each once, and a range of at least one number, found "
            + (", ".join([*odd, *twice]) or f"{len(channels)} channels and {len(free)} ranges")
            + (nearest(odd[0], CHANNELS) if odd else "")
        )


def _range(scene: Scene, key: str, free: Mapping[str, GivenRange]) -> tuple[float, float]:
    """Ends of the range of a number of the scene; the sentence on an unknown key names the key near to it."""
    try:
        return range_of(scene, key, free[key], {other: given for other, given in free.items() if other != LOAD})
    except SceneError:
        known = [LOAD, *_numbers(scene)]
        if (wanted := key.removeprefix("effects.")) in known:
            raise
        near = nearest(wanted, known)
        raise ArgumentError(
            f"free: expected {LOAD}, or a number of an effect or rig.top_drive, found {key}{near}"
        ) from None


def _numbers(scene: Scene) -> Iterator[str]:
    """Keys of the numbers of effects and top drive."""
    content = scene.model_dump(mode="json", exclude_none=True)
    for place, block in {**content["effects"], "rig.top_drive": content["rig"].get("top_drive", {})}.items():
        yield from (f"{place}.{name}" for name, value in block.items() if type(value) in {int, float})


def _ends(given: str | tuple[float, float]) -> tuple[float, float]:
    """Ends of the range of a factor."""
    try:
        low, high, *rest = parse_range(LOAD, given) if isinstance(given, str) else given
    except (TypeError, ValueError):
        low, high, rest = 1.0, 1.0, []
    if not 0.0 < low < high < float("inf") or any(rest):
        raise ArgumentError(f'{LOAD}: expected a range of a factor as "0.8..1.2", found {given!r}')
    return low, high
