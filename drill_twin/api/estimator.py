# SPDX-License-Identifier: Apache-2.0
"""Estimator for Python: samples of a rig in, estimates out (docs/estimator.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from numbers import Real
from pathlib import Path
from typing import Any

from drill_twin.api.parameter_fit import range_of
from drill_twin.api.scenes import Overrides, as_scene
from drill_twin.errors import ArgumentError, SceneError
from drill_twin.estimation import CHANNELS, LOAD, SET_POINTS, EnsembleFilter, Estimate, EstimatorOptions, Intake
from drill_twin.fitting import Record
from drill_twin.scene import Scene
from drill_twin.scene.problems import nearest

_NOTHING: Mapping[str, float] = {}


class Estimator:
    """An ensemble that follows a rig; state in, state out, no clock of its own.

    >>> estimator = Estimator("pa6_bench", {"wall_friction.coefficient": "0.1..0.4", "load_factor": "0.8..1.2"})
    >>> estimator.take(stamp, {"torque": 0.9, "hookload": 31.0, "weight_on_bit": 40.0, "rotation": 12.6})
    >>> while (estimate := estimator.step()) is not None:
    ...     print(estimate.time, estimate.numbers["load_factor"].mean, estimate.alarm)

    Attributes:
        scene: The scene.
        intake: Samples on their way to windows; has the troubles with them.
        filter: The ensemble.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        free: Mapping[str, str | tuple[float, float]],
        *,
        channels: Sequence[str] = ("torque", "hookload"),
        overrides: Overrides | None = None,
        options: EstimatorOptions | None = None,
    ) -> None:
        """Make the ensemble.

        Args:
            scene: The scene.
            free: Range of each free number by key, as of `fit`: numbers of effects and of `rig.top_drive`, and
                `load_factor`, weight on bit over the one that is commanded or indicated.
            channels: Channels that correct: torque, motor_torque (with inertia and bearings of the drive), hookload,
                top_drive_speed, bit_speed.
            overrides: Values that replace those of the scene.
            options: Members, windows, errors, horizon.

        Raises:
            ArgumentError: A channel or a number that cannot be taken.
            SceneError: A range does not fit the scene.
        """
        self.scene = as_scene(scene, overrides)
        _check(channels, free)
        ranges = {key: _ends(given) if key == LOAD else _range(self.scene, key, given) for key, given in free.items()}
        self.filter = EnsembleFilter(self.scene, ranges, channels, options or EstimatorOptions())
        self.intake = Intake(self.filter.pace, self.scene, channels)

    def take(self, stamp: float, values: Mapping[str, float] = _NOTHING) -> None:
        """Take a sample.

        Args:
            stamp: Its time [s], of any clock.
            values: Channels, `weight_on_bit` [N] and `rotation` [rad/s] by name; NaN where there is none. Set-points
                that never come are the scene's.

        Raises:
            ArgumentError: A name of none of them, or what is no number.
        """
        if not isinstance(values, Mapping) or not all(isinstance(one, Real) for one in (stamp, *values.values())):
            raise ArgumentError(
                f'expected a time [s] and numbers by name, as take(0.1, {{"torque": 1e3}}), found {stamp!r} and '
                f"{values!r}"
            )
        if odd := sorted(map(str, values.keys() - {*CHANNELS, *SET_POINTS})):
            raise ArgumentError(f"expected values of {', '.join((*CHANNELS, *SET_POINTS))}, found {', '.join(odd)}")
        self.intake.take(stamp, values)

    def step(self) -> Estimate | None:
        """Estimate at the end of the next whole window; None while there is none.

        Raises:
            RunError: No member could be followed.
        """
        window = self.intake.window()
        return None if window is None else self.filter.advance(window)

    def follow(self, record: Record) -> Iterator[Estimate]:
        """Estimates over a record."""
        samples: dict[float, dict[str, float]] = {}
        for name, (time, values) in record.series.items():
            for stamp, value in zip(time.tolist(), values.tolist(), strict=True):
                samples.setdefault(stamp, {})[name] = value
        self.take(0.0)
        for stamp in sorted(samples):
            self.take(stamp, samples[stamp])
            while (found := self.step()) is not None:
                yield found


def _check(channels: Sequence[str], free: Mapping[str, Any]) -> None:
    """Refuse channels and free numbers that are none, unknown or given twice."""
    if isinstance(channels, str) or not isinstance(free, Mapping):
        raise ArgumentError(
            'expected a list of channels, as ["torque", "hookload"], and ranges by key, as '
            f'{{"{LOAD}": "0.8..1.2"}}, found {channels!r} and {free!r}'
        )
    odd = [str(name) for name in channels if name not in CHANNELS]
    if odd or not channels or not free:
        raise ArgumentError(
            f"expected channels of {', '.join(CHANNELS)} and a range of at least one number, found "
            + (", ".join(odd) or f"{len(channels)} channels and {len(free)} ranges")
            + (nearest(odd[0], [*CHANNELS]) if odd else "")
        )
    if len(set(channels)) < len(channels):
        raise ArgumentError(f"expected each channel once, found {', '.join(channels)}")


def _range(scene: Scene, key: str, given: str | tuple[float, float]) -> tuple[float, float]:
    """Ends of the range of a number of the scene; the sentence on an unknown key names those that are near to it."""
    try:
        return range_of(scene, key, given)
    except SceneError:
        known, wanted = [LOAD, *_numbers(scene)], key.removeprefix("effects.")
        if wanted in known:
            raise
        near = get_close_matches(wanted, known, n=3)
        raise ArgumentError(
            f"free: expected {LOAD} or the key of a number of an effect or of rig.top_drive, found {key}; "
            + (f"near it: {', '.join(near)}" if near else f"known: {', '.join(known)}")
        ) from None


def _numbers(scene: Scene) -> Iterator[str]:
    """Keys of the numbers of effects and top drive."""
    content = scene.model_dump(mode="json", exclude_none=True)
    for place, block in {**content["effects"], "rig.top_drive": content["rig"].get("top_drive", {})}.items():
        yield from (f"{place}.{name}" for name, value in block.items() if type(value) in {int, float})


def _ends(given: str | tuple[float, float]) -> tuple[float, float]:
    """Ends of the range of a factor."""
    try:
        low, high = (float(end) for end in (given.split("..") if isinstance(given, str) else given))
    except (TypeError, ValueError):
        low, high = 1.0, 1.0
    if not 0.0 < low < high < float("inf"):
        raise ArgumentError(f'{LOAD}: expected a range of a factor as "0.8..1.2", found {given!r}')
    return low, high
