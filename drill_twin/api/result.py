# SPDX-License-Identifier: Apache-2.0
"""The result of a run, from memory or from a bag: arrays over time, findings, figures."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drill_twin.api.result_views import Cost, Named, Plots
from drill_twin.api.scenes import in_si
from drill_twin.api.whirl import Whirl
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError
from drill_twin.core.table import Table
from drill_twin.core.units.dimension import TIME
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.sensor_series import Measured
from drill_twin.io.bag.series import MarkSeries, PoseSeries
from drill_twin.io.bag.virtual_bags import copy_bag
from drill_twin.io.scene_geometry import sub_analyzer
from drill_twin.report.load_text import answers
from drill_twin.report.recording import Recording
from drill_twin.report.selection import Selection, open_bag
from drill_twin.report.summary import summarise
from drill_twin.report.text import findings
from drill_twin.scene import Scene
from drill_twin.whirl import Onset, Summary

if TYPE_CHECKING:
    import pandas as pd
    import xarray


class Result(Plots):
    """Arrays, findings and figures of a run; of a bag with several runs, the last or the chosen one.

    Everything is read on first use. T samples, m marks in the order of the scene, n + 1 nodes from the bit (0) to the
    top clamp (n). Positions are in the frame `hole`: origin at the top clamp, z up along the hole, x to the low side.
    Each group has its own `time`; in a run of this package each is equal to `Result.time`.
    """

    def __init__(
        self,
        bag: Bag,
        scene: Scene | None = None,
        selection: Selection | None = None,
        findings: Summary | None = None,
    ) -> None:
        """Take the result of `Simulation.run` or `read_bag` instead.

        Args:
            bag: The bag, in memory or on disk.
            scene: The scene of the run; by default the one in the bag.
            selection: The part of the bag that is read; by default all.
            findings: Findings of the run, where it was analysed while it went on; by default the bag is analysed.
        """
        self._bag, self._given, self._selection, self._findings = bag, scene, selection, findings

    @cached_property
    def recording(self) -> Recording:  # type: ignore[override]  # set once, on first use
        """The run as the report reads it."""
        return Recording(self._bag, self._given, self._selection)

    def __repr__(self) -> str:
        """One line: scene, length, onset."""
        name = self.scene.name if self.recording.scene_known else str(self.path)
        said = f"whirl {'before' if on.at_start else 'from'} {on.time_s:.2f} s" if (on := self.onset) else "no whirl"
        return f"<Result of {name}: {self.time.size} samples to {self.recording.duration:g} s, {said}>"

    def _repr_html_(self) -> str:
        """The same line and the rows of `summary`, for a notebook."""
        return f"<p>{escape(repr(self))}</p>{Table((), [*answers(self.summary), *findings(self.summary)]).html()}"

    @property
    def path(self) -> Path:
        """Path of the bag; of a run in memory its name."""
        return self._bag.path

    @property
    def scene(self) -> Scene:
        """The scene of the run.

        Raises:
            BagError: The bag does not say, and none was given.
        """
        return self.recording.scene

    @property
    def time(self) -> Array:
        """Simulated times of the samples [s], shape (T,)."""
        return self.rig.time if len(self.rig) else self.marks.time

    @property
    def marks(self) -> MarkSeries:
        """Marks: `names`, `time` (T,), `position` [m] (T, m, 3), `spin` [rad] (T, m), `velocity` [m/s] (T, m, 3),
        `spin_rate` [rad/s] (T, m), `wall_force` on the string [N] (T, m, 3).
        """
        return self.recording.marks

    @cached_property
    def centre(self) -> Array:
        """Centre line at the marks, across the hole from its axis [m], shape (T, m, 2)."""
        line = self.recording.centre_lines()
        return np.stack((line.real, line.imag), axis=-1)

    @cached_property
    def string(self) -> PoseSeries:
        """String: `time` (T,), `position` of the nodes [m] (T, n + 1, 3), `tangent` (T, n + 1, 3), `orientation` as
        quaternion x y z w (T, n + 1, 4), `spin` [rad] (T, n + 1).
        """
        return self.recording.all_poses()

    @cached_property
    def measured(self) -> Measured:
        """Measurements: `subs` by name, each with `imu` (`force` [m/s^2], `rate` [rad/s], shape (T, 3)) and `summary`;
        `surface` of a simulated rig and `rig` of a real one, with the columns of `rig`.
        """
        return Measured(self._bag)

    def whirl_from_sub(self, name: str) -> Summary:
        """Findings of the whirl analysis from the readings of one downhole sub alone (docs/sensors.md).

        Raises:
            ArgumentError: The bag has no readings of this sub, or the scene does not list it.
            AnalysisError: The readings are not evenly spaced, do not turn, or are too few.
        """
        read = {key: sub for key, sub in self.measured.subs.items() if len(sub.imu)}
        if name not in read:
            raise ArgumentError(f"expected a sub with readings, one of {', '.join(read) or 'none'}, found {name!r}")
        analyzer = sub_analyzer(self.scene, name)
        for stamp, values in zip(read[name].imu.stamp.tolist(), read[name].imu.values, strict=True):
            analyzer.push(stamp, values)
        return analyzer.checked_summary()

    @property
    def wall_force(self) -> Array:
        """Normal force of the wall on the string at the marks [N], shape (T, m)."""
        force: Array = np.linalg.norm(self.marks.wall_force, axis=-1)
        return force

    @property
    def whirl(self) -> Whirl:
        """Findings of the whirl analysis over time and in all."""
        found, summary = self.recording.whirl, self.recording.summary
        columns = found.orbit_radius, found.precession, found.ratio, found.confidence
        radii, precession, ratio, confidence = (rows if len(found) else np.zeros((0, 0)) for rows in columns)
        return Whirl(found.time, found.names, radii, precession, ratio, confidence, summary, summary.notes)

    @property
    def onset(self) -> Onset | None:
        """Onset of whirl: time, mark, confidence, criterion; None where there was none."""
        return (self._findings or self.recording.summary).onset

    @property
    def onset_s(self) -> float | None:
        """Onset of whirl [s]; None where there was none."""
        return None if self.onset is None else self.onset.time_s

    @property
    def cost(self) -> Cost:
        """Resolution of the run and the time it took."""
        summary = self.summary
        keys = ("realtime_factor", "physics_speed", "elements", "step_s", "steps", "cut_steps", "steps_above_tolerance")
        return Cost(*(summary[key] for key in keys))

    @cached_property
    def summary(self) -> Named:
        """All findings in plain types, by key or as attributes: the content of `summary.json`."""
        return Named(summarise(self.recording))

    def to_xarray(self) -> xarray.Dataset:
        """Arrays of marks, rig, set-points and whirl as a dataset with named dimensions and units.

        Raises:
            ArgumentError: xarray is not installed.
        """
        from drill_twin.api.result_views import dataset

        found = {"onset_s": self.onset_s, "whirl_frequency_hz": self.whirl.frequency_hz}
        source = {"source": str(self.path), **{key: value for key, value in found.items() if value is not None}}
        return dataset(self.time, self.rig, self.marks, self.set_points, self.whirl, source)

    def to_pandas(self) -> pd.DataFrame:
        """The arrays of `to_xarray` as a table over the time [s]: a column a quantity, with its SI unit in the heading.

        Columns are named `hookload [N]`, and a mark's columns `mark_1/position/x [m]`. Groups with times of their own
        have rows of their own, empty elsewhere.

        Raises:
            ArgumentError: xarray, which brings pandas, is not installed.
        """
        from drill_twin.api.result_views import table

        return table(self.to_xarray())

    def animate(
        self, path: str | Path, *, begin: float | None = None, end: float | None = None, speed: float = 1.0
    ) -> Path:
        """Write a moving picture: the string in its hole over depth towards x and y, and the orbits of the marks.

        >>> result.animate("run.gif", begin=4, end=10)

        Args:
            path: File, .gif, or .mp4 where ffmpeg is on the PATH.
            begin: Time of the first frame [s]; left out: ten seconds before the last.
            end: Time of the last frame [s]; left out: the end of the run.
            speed: Simulated over shown time.

        Returns:
            The file.

        Raises:
            ArgumentError: Another kind of file, times that hold nothing, or a recording without poses or marks.
        """
        from drill_twin.api.animation import animate

        return animate(self, path, begin, end, speed)

    def sel(self, time: slice) -> Result:
        """A part of the run, analysed by itself: motion, frequency and onset are found in the part alone.

        >>> result.sel(time=slice("5 s", "10 s")).centre

        Args:
            time: Start and end [s], or text with a unit; None: as far as the run goes.

        Raises:
            ArgumentError: No slice of two rising times.
            BagError: Nothing lies between them.
        """
        old = self._selection or Selection()
        if not isinstance(time, slice) or time.step is not None:
            raise ArgumentError(f'time: expected slice(start, end), such as slice("5 s", "10 s"), found {time!r}')
        ends = (time.start, -math.inf), (time.stop, math.inf)
        begin, end = (open_end if at is None else in_si("time", at, TIME) for at, open_end in ends)
        first, last = max(begin, old.begin), min(end, old.end)
        if not first < last:
            raise ArgumentError(f"time: expected a start before the end, found {first:g} s and {last:g} s")
        part = Result(self._bag, self._given, replace(old, begin=first, end=last))
        _ = part.recording
        return part

    def to_bag(self, folder: str | Path) -> Path:
        """Write the messages of the run to a new bag folder; returns the folder.

        Raises:
            BagError: The folder exists or cannot be written.
        """
        return copy_bag(self._bag, folder)


def read_bag(
    path: str | Path,
    *,
    scene: Scene | None = None,
    begin: float = -math.inf,
    end: float = math.inf,
    namespace: str | None = None,
    sub: str = "",
    run: int = 0,
) -> Result:
    """Open a bag, or the bag in the folder of a run, and analyse it.

    Args:
        path: Folder of a run or a bag, a bag file, or a record of a rig (CSV, MAT, LAS, WITSML).
        scene: The scene of the run, where the bag does not hold it.
        begin: Samples before this time are left out [s].
        end: Samples after this time are left out [s].
        namespace: Namespace of the twin, as "/rig2", where the bag holds several.
        sub: Downhole sub whose readings are analysed instead of the marks, `measured/NAME` for a sub of a real rig.
        run: Number of the run, from 1, in a bag with several; 0: the last.

    Raises:
        BagError: Not a bag of this package, nothing in it that could be analysed, or several twins without a choice.
        TableError: The record cannot be read.
    """
    selection = Selection(begin=begin, end=end, namespace=namespace, sub=sub, run=run)
    result = Result(open_bag(path, selection), scene, selection)
    _ = result.recording
    return result
