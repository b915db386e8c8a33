# SPDX-License-Identifier: Apache-2.0
"""A result as an xarray dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.extras import import_extra

if TYPE_CHECKING:
    import xarray

    from drill_twin.api.results.result import Result

_RIG = {
    "hookload": ("hookload", "N"),
    "torque": ("top_drive_torque", "N m"),
    "bit_torque": ("bit_torque", "N m"),
    "weight_on_bit": ("bit_force", "N"),
    "top_drive_angle": ("top_drive_angle", "rad"),
    "top_drive_speed": ("top_drive_speed", "rad/s"),
    "bit_angle": ("bit_angle", "rad"),
    "bit_speed": ("bit_speed", "rad/s"),
    "block_position": ("block_position", "m"),
    "block_velocity": ("block_velocity", "m/s"),
}
_MARKS = {
    "position": (("mark", "axis"), "m"),
    "velocity": (("mark", "axis"), "m/s"),
    "wall_force": (("mark", "axis"), "N"),
    "spin": (("mark",), "rad"),
    "spin_rate": (("mark",), "rad/s"),
}
_WHIRL = {"orbit_radius": "m", "precession": "rev/s", "ratio": "1", "confidence": "1"}
_SET_POINTS = {"weight_on_bit": "N", "rotation": "rad/s"}


def dataset(result: Result) -> xarray.Dataset:
    """Marks, rig, set-points and whirl of a result; each variable has its unit as attribute `units`.

    Dimensions: `time` [s], `mark` (names), `axis` (x, y, z). A group sampled at other times than the rig has a time
    dimension of its own: `time_marks`, `time_set_points`, `time_whirl`.

    Raises:
        ArgumentError: xarray is not installed.
    """
    labelled = import_extra("xarray")
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", result.time, {"units": "s"})}

    def times(group: str, time: Array) -> str:
        if np.array_equal(time, result.time):
            return "time"
        name = f"time_{group}"
        coordinates[name] = (name, time, {"units": "s"})
        return name

    if len(result.rig):
        for name, (column, unit) in _RIG.items():
            variables[name] = ("time", getattr(result.rig, column), {"units": unit})
    if len(result.marks):
        coordinates |= {"mark": list(result.marks.names), "axis": ["x", "y", "z"]}
        at = times("marks", result.marks.time)
        for name, (dimensions, unit) in _MARKS.items():
            variables[f"mark_{name}"] = ((at, *dimensions), getattr(result.marks, name), {"units": unit})
    if len(result.set_points):
        at = times("set_points", result.set_points.time)
        for name, unit in _SET_POINTS.items():
            variables[f"commanded_{name}"] = (at, getattr(result.set_points, name), {"units": unit})
    whirl = result.whirl
    if whirl.time.size:
        at = times("whirl", whirl.time)
        coordinates.setdefault("mark", list(whirl.marks))
        for name, unit in _WHIRL.items():
            variables[name] = ((at, "mark"), getattr(whirl, name), {"units": unit})
    found = {"onset_s": result.onset_s, "whirl_frequency_hz": whirl.frequency_hz}
    attributes = {"source": str(result.path), **{key: value for key, value in found.items() if value is not None}}
    labelled_arrays: xarray.Dataset = labelled.Dataset(variables, coordinates, attributes)
    return labelled_arrays
