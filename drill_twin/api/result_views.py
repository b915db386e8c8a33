# SPDX-License-Identifier: Apache-2.0
"""Results as figures and tables: of a run, also as an xarray dataset and a pandas table, of modes and of statics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.api.scenes import RPM
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, import_extra, nearest
from drill_twin.core.rig_channels import FIELDS, channel_of
from drill_twin.core.table import Shown
from drill_twin.dynamics.rotordynamics.campbell import Campbell, GrowthMap
from drill_twin.dynamics.rotordynamics.modes import ModeTable
from drill_twin.dynamics.torque_drag.analysis import Statics

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.figure import Figure

    from drill_twin.api.whirl import Whirl
    from drill_twin.io.bag.series import CommandSeries, MarkSeries, RigSeries, StressSeries
    from drill_twin.report.recording import Recording


def _plot(name: str, what: str) -> Callable[[Plots], Figure]:
    """Method that draws the figure of this name (`drill_twin.report.figures`)."""

    def draw_it(plots: Plots) -> Figure:
        return plots.plot(name)

    draw_it.__name__, draw_it.__qualname__, draw_it.__doc__ = f"plot_{name}", f"Plots.plot_{name}", what
    return draw_it


@dataclass(frozen=True)
class Cost:
    """Cost of a run; None where the bag does not say."""

    realtime_factor: float | None
    """Simulated over wall time."""
    physics_speed: float | None
    """Simulated time over the time spent computing the motion."""
    elements: int | None
    """Elements of the string."""
    step: float | None
    """Nominal time step [s]."""
    steps: int | None
    """Time steps taken."""
    cut_steps: int | None
    """Steps that had to be halved."""
    steps_above_tolerance: int | None
    """Steps taken within ten tolerances instead of one."""


def _by(module: str, name: str, what: str) -> Callable[[Any], Any]:
    """Method that returns what a function of `drill_twin.studies` makes of its object."""

    def made(found: Any) -> Any:
        return getattr(import_module(f"drill_twin.studies.{module}"), name)(found)

    made.__doc__ = what
    return made


class Modes(Shown, ModeTable):
    """Modes about a balance, with their table and figure."""

    shown = _by("modes", "modes_table", "Table of `drill-twin modes`.")
    plot = _by("modes", "shapes_figure", "Figure of the shapes of the lateral modes along the string.")


class CampbellDiagram(Shown, Campbell):
    """Lateral modes over speeds of rotation, with their figure."""

    shown = _by("modes", "campbell_table", "Load, speeds and critical speeds.")
    plot = _by("modes", "campbell_figure", "Figure of frequency and growth over the speed; critical speeds marked.")


class GrowthPlane(GrowthMap):
    """Growth rates over loads and speeds, with their figure."""

    plot = _by("modes", "growth_figure", "Figure of the largest growth rate over weight and speed, with its zero line.")


class StaticLoads(Shown, Statics):
    """Loads of a scene in the operations of the rig, with their table and figure."""

    shown = _by("statics", "loads_table", "First table of `drill-twin statics`.")
    plot = _by("statics", "tracks", "Figure of tension, torque, side force and compression over depth.")


class Channels:
    """Quantities of the rig over time, each of shape (T,)."""

    recording: Recording
    """The run as the report reads it."""

    @property
    def set_points(self) -> CommandSeries:
        """Set-points as commanded: `time`, `weight_on_bit` [N], `rotation` [rad/s], each of shape (T,)."""
        return self.recording.commands

    @property
    def rig(self) -> RigSeries:
        """Rig and bit as they moved: angles [rad], speeds [rad/s], torques [N m], forces [N], each of shape (T,)."""
        return self.recording.rig

    @property
    def energy(self) -> dict[str, Array]:
        """Energy balance over time, where the scene has `numerics.audit: energy`; else empty.

        `time` [s] and values, shape (K,), about once a simulated second: `stored_...`, `work_...` and `dissipated_...`
        by effect [J], `residual` as a share of `scale_J`.
        """
        return self.recording.log.energy

    @property
    def stress(self) -> StressSeries:
        """Sections of the effect `fatigue`: `names`, `time`, `moment_x`, `moment_y` [N m], `axial_force` [N], `stress`,
        `largest_stress` [Pa], `cycles`, `damage`, shape (T, s); `summary["fatigue"]` has the time to a damage of 1.
        """
        return self.recording.stress

    @property
    def hookload(self) -> Array:
        """Force that holds the string at the top [N]."""
        return self.rig.hookload

    @property
    def rpm(self) -> Array:
        """Speed of the top drive [rev/min]."""
        return self.rig.top_drive_speed / RPM

    @property
    def torque(self) -> Array:
        """Torque of the top drive on the string [N m]."""
        return self.rig.top_drive_torque

    @property
    def bit_torque(self) -> Array:
        """Torque of the rock on the bit [N m]."""
        return self.rig.bit_torque

    @property
    def weight_on_bit(self) -> Array:
        """Weight on bit as applied [N], positive = compression."""
        return self.rig.bit_force

    @property
    def bit_speed(self) -> Array:
        """Speed of the bit [rad/s]."""
        return self.rig.bit_speed


class Plots(Channels):
    """Methods that return matplotlib figures; a notebook shows them, `figure.savefig(file)` writes them."""

    def plot(self, name: str = "") -> Figure:
        """Figure of the report by its name; left out: the displacement of the marks, or set-points without marks.

        Raises:
            ArgumentError: No such figure, or the recording does not hold what it draws.
        """
        from drill_twin.report import draw
        from drill_twin.report.figures import FIGURES, left_out

        lacking = left_out(self.recording)
        known = [one for one in FIGURES if one not in lacking]
        if (chosen := name or ("displacement" if "displacement" in known else "set_points")) not in known:
            why = f" (the recording holds {lacking[chosen]})" if chosen in lacking else nearest(chosen, known)
            raise ArgumentError(f"name: expected one of {', '.join(known) or 'none'}, found {chosen!r}{why}")
        return draw(chosen, self.recording)

    def report(self, folder: str | Path) -> Path:
        """Write `report.html`, which is complete alone, `summary.json` and the figures; returns the page.

        Raises:
            BagError: The folder cannot be written.
        """
        from drill_twin.report import build_report

        return build_report(self.recording, folder).page

    plot_set_points = _plot("set_points", "Weight on bit and rotation over time, commanded and applied.")
    plot_displacement = _plot("displacement", "Displacement of the centre line at the marks over time.")
    plot_motion = _plot("motion", "Motion states and whirl ratio over time.")
    plot_spectrum_over_time = _plot("spectrum_over_time", "Two-sided spectrum of the motion across the hole over time.")
    plot_spectrum = _plot("spectrum", "Two-sided spectrum of the motion across the hole after the onset.")
    plot_orbits = _plot("orbits", "Orbits of the centre line at the marks across the hole.")
    plot_well = _plot("well", "The string in the well at the end, and tracks over measured depth.")
    plot_string_shapes = _plot("string_shapes", "Shapes of the string in the hole, and the paths of the marks.")


class Named(dict[str, Any]):
    """Findings by key, `summary["onset_s"]`, and as attributes, `summary.onset_s`."""

    def __getattr__(self, name: str) -> Any:
        """Finding of this name."""
        if name in self:
            return self[name]
        raise AttributeError(f"expected a key of summary.json, found {name!r}{nearest(name, self)}")


_RIG = (
    "hookload", "torque", "bit_torque", "weight_on_bit", "top_drive_angle", "top_drive_speed", "bit_angle", "bit_speed",
    "block_position", "block_velocity", "drilled", "rate_of_penetration",
)  # fmt: skip
_MARKS = {
    "position": (("mark", "axis"), "m"),
    "velocity": (("mark", "axis"), "m/s"),
    "wall_force": (("mark", "axis"), "N"),
    "spin": (("mark",), "rad"),
    "spin_rate": (("mark",), "rad/s"),
}
_WHIRL = {"orbit_radius": "m", "precession": "rev/s", "ratio": "1", "confidence": "1"}
_SET_POINTS = ("weight_on_bit", "rotation")


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
    labelled, variables = import_extra("xarray"), dict[str, Any]()
    coordinates: dict[str, Any] = {"time": ("time", time, {"units": "s"})}

    def times(group: str, of_group: Array) -> str:
        name = "time" if np.array_equal(of_group, time) else f"time_{group}"
        coordinates.setdefault(name, (name, of_group, {"units": "s"}))
        return name

    if len(rig):
        for name in _RIG:
            variables[name] = ("time", getattr(rig, FIELDS[name]), {"units": channel_of(name).dimension.unit})
    if len(marks):
        coordinates |= {"mark": list(marks.names), "axis": ["x", "y", "z"]}
        at = times("marks", marks.time)
        for name, (dimensions, unit) in _MARKS.items():
            variables[f"mark_{name}"] = ((at, *dimensions), getattr(marks, name), {"units": unit})
    if len(set_points):
        at = times("set_points", set_points.time)
        for name in _SET_POINTS:
            units = {"units": channel_of(name).dimension.unit}
            variables[f"commanded_{name}"] = (at, getattr(set_points, name), units)
    if whirl.time.size:
        at = times("whirl", whirl.time)
        coordinates.setdefault("mark", list(whirl.marks))
        for name, unit in _WHIRL.items():
            variables[name] = ((at, "mark"), getattr(whirl, name), {"units": unit})
    labelled_arrays: xarray.Dataset = labelled.Dataset(variables, coordinates, dict(attributes))
    return labelled_arrays


def table(data: xarray.Dataset) -> pd.DataFrame:
    """Table of a dataset of `dataset` over time, units in the headings."""
    pandas = import_extra("pandas")
    columns: dict[str, dict[str, Any]] = {}
    for name, variable in data.data_vars.items():
        at, *others = variable.dims
        whole, unit = variable.to_numpy().reshape(variable.shape[0], -1), variable.attrs["units"]
        labels = product(*(data[dimension].to_numpy().tolist() for dimension in others))
        short = str(name).removeprefix("mark_") if "mark" in others else str(name)
        for column, label in zip(whole.T, labels, strict=True):
            heading = "/".join([*label[:1], short, *label[1:]])
            columns.setdefault(str(at), {})[f"{heading} [{unit}]"] = column
    times = {at: pandas.Index(data[at].to_numpy(), name="time [s]") for at in columns}
    joined: pd.DataFrame = pandas.concat([pandas.DataFrame(columns[at], index=times[at]) for at in columns], axis=1)
    return joined
