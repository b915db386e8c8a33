# SPDX-License-Identifier: Apache-2.0
"""Set-points as functions of time."""

import math
from collections.abc import Callable

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import SceneError
from drill_twin.scene.blocks.rig import SetPoint
from drill_twin.scene.set_point_shapes import ADDED

SetPointAt = Callable[[float], float]
"""Time [s] -> value of a set-point."""


def shape(set_point: SetPoint) -> SetPointAt:
    """Function of time of a set-point that is not recorded.

    Raises:
        SceneError: Its shape is `table`, or one of another package that cannot be loaded.
    """
    initial, final, start, duration = set_point.initial, set_point.value, set_point.start, set_point.duration
    if set_point.shape == "constant":
        return lambda _: final
    if set_point.shape == "step":
        return lambda time: step(time, start, initial, start + duration, final)
    if set_point.shape == "ramp":
        return lambda time: ramp(time, start, initial, start + duration, final)
    if set_point.shape in ADDED:
        return _added(set_point)
    raise SceneError(f'expected a set-point with a value, found shape "{set_point.shape}"')


def _added(set_point: SetPoint) -> SetPointAt:
    """Function of time of a set-point whose shape comes from another package."""
    entry = ADDED[set_point.shape]
    try:
        function: SetPointAt = entry.load()(set_point)
        value = float(function(0.0))
    except Exception as error:
        raise SceneError(
            f'shape "{set_point.shape}": expected a function of time from {entry.value}, found '
            f"{type(error).__name__}: {error}; mend or uninstall its package"
        ) from error
    if not math.isfinite(value):
        raise SceneError(f'shape "{set_point.shape}": expected a finite value at 0 s, found {value!r} ({entry.value})')
    return lambda time: float(function(time))


def step(time: float, start: float, before: float, end: float, after: float) -> float:
    """Cubic from `before` to `after` with zero slope at both ends (STEP of ADAMS); a jump if start = end."""
    return before + (after - before) * _smooth(_progress(time, start, end))


def ramp(time: float, start: float, before: float, end: float, after: float) -> float:
    """Straight line from `before` to `after`; a jump if start = end."""
    return before + (after - before) * _progress(time, start, end)


def table(times: Array, values: Array, start: float) -> SetPointAt:
    """Linear interpolation of measurements, from `start` [s] into the record; constant beyond its ends."""
    origin = float(times[0]) + start
    return lambda time: float(np.interp(origin + time, times, values))


def _progress(time: float, start: float, end: float) -> float:
    if time < start:
        return 0.0
    return 1.0 if time >= end else (time - start) / (end - start)


def _smooth(x: float) -> float:
    return x * x * (3.0 - 2.0 * x)
