# SPDX-License-Identifier: Apache-2.0
"""A result as an xarray dataset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.api.results.whirl import Whirl
from drill_twin.core.arrays import Array
from drill_twin.core.extras import import_extra
from drill_twin.io.bag.series import CommandSeries, MarkSeries, RigSeries

if TYPE_CHECKING:
    import xarray

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


def dataset(
    time: Array,
    rig: RigSeries,
    marks: MarkSeries,
    set_points: CommandSeries,
    whirl: Whirl,
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Marks, rig, set-points and whirl of a run; each variable has its unit as attribute `units`.

    Dimensions: `time` [s], `mark` (names), `axis` (x, y, z). A group sampled at other times than the rig has a time
    dimension of its own: `time_marks`, `time_set_points`, `time_whirl`.

    Args:
        time: Times of the samples [s], shape (T,).
        rig: Quantities of the rig.
        marks: Motion of the marks.
        set_points: Set-points as commanded.
        whirl: Whirl over time.
        attributes: Attributes of the dataset: source and findings.

    Raises:
        ArgumentError: xarray is not installed.
    """
    labelled = import_extra("xarray")
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", time, {"units": "s"})}

    def times(group: str, of_group: Array) -> str:
        if np.array_equal(of_group, time):
            return "time"
        name = f"time_{group}"
        coordinates[name] = (name, of_group, {"units": "s"})
        return name

    if len(rig):
        for name, (column, unit) in _RIG.items():
            variables[name] = ("time", getattr(rig, column), {"units": unit})
    if len(marks):
        coordinates |= {"mark": list(marks.names), "axis": ["x", "y", "z"]}
        at = times("marks", marks.time)
        for name, (dimensions, unit) in _MARKS.items():
            variables[f"mark_{name}"] = ((at, *dimensions), getattr(marks, name), {"units": unit})
    if len(set_points):
        at = times("set_points", set_points.time)
        for name, unit in _SET_POINTS.items():
            variables[f"commanded_{name}"] = (at, getattr(set_points, name), {"units": unit})
    if whirl.time.size:
        at = times("whirl", whirl.time)
        coordinates.setdefault("mark", list(whirl.marks))
        for name, unit in _WHIRL.items():
            variables[name] = ((at, "mark"), getattr(whirl, name), {"units": unit})
    labelled_arrays: xarray.Dataset = labelled.Dataset(variables, coordinates, dict(attributes))
    return labelled_arrays
