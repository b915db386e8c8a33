# SPDX-License-Identifier: Apache-2.0
"""Whirl found in a run, or in plain arrays of anyone's measurement."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.api.scenes import Quantity, in_si
from drill_twin.core.arrays import Array
from drill_twin.core.table import Shown, Table
from drill_twin.core.units.dimension import ANGULAR_SPEED, LENGTH
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.report.load_text import number_text
from drill_twin.report.summary import timeline
from drill_twin.report.text import frequency_text, lasting, onset_text
from drill_twin.whirl import AnalysisError, Analyzer, MarkInfo, MotionPeriod, Onset, Summary
from drill_twin.whirl.analyzer import LARGEST_STAMP

CLEARANCE_TAKEN = (
    "no clearance was given: the largest distance from the axis is taken for it, so radii count as shares of the "
    "largest motion in this record, and a record without whirl may seem to whirl; give clearance="
)
"""Note on an analysis without a clearance."""


LATEST = LARGEST_STAMP / NANOSECONDS
"""Latest time that a stamp can hold [s]: 146 years."""


@dataclass(frozen=True, eq=False, repr=False)
class Whirl(Shown):
    """Whirl over time and in all; T samples, m marks."""

    time: Array
    """Times [s], shape (T,)."""
    marks: tuple[str, ...]
    """Names of the marks."""
    orbit_radius: Array
    """Distance of the centre line from the axis [m], shape (T, m)."""
    precession: Array
    """Precession [rev/s], positive in the sense of rotation (forward), shape (T, m); NaN where there is none."""
    ratio: Array
    """Whirl ratio, shape (T, m)."""
    confidence: Array
    """Clearness of both, a rank from 0 to 1, shape (T, m)."""
    summary: Summary
    """Findings for the whole record: onset, frequency, largest radii, motion, stick-slip, quality."""
    notes: tuple[str, ...] = ()
    """Limits of these findings, in words."""

    @property
    def onset(self) -> Onset | None:
        """Onset of whirl: time, mark, confidence, criterion; None where there was none."""
        return self.summary.onset

    @property
    def onset_s(self) -> float | None:
        """Onset of whirl [s]."""
        return self.summary.onset_s

    @property
    def frequency_hz(self) -> float | None:
        """Dominant whirl after the onset [Hz], positive = forward."""
        return self.summary.whirl_frequency_hz

    @property
    def motion(self) -> list[dict[str, Any]]:
        """Motion states of the string in order: `start_s`, `end_s`, `state`, `criterion`."""
        return self._timeline(self.summary.motion)

    @property
    def mark_motion(self) -> dict[str, list[dict[str, Any]]]:
        """Motion states of each mark in order, by its name, with the keys of `motion`."""
        return {mark: self._timeline(periods) for mark, periods in self.summary.mark_motion.items()}

    def shown(self) -> Table:
        """Findings in words, for a prompt and a notebook."""
        found = self.summary.to_dict() | {f"onset_{k}": getattr(self.onset, k, None) for k in Onset.__annotations__}
        radii = (f"{mark} {number_text(radius, '{:.4g} m')}" for mark, radius in found["max_radius_m"].items())
        rows = [("motion that lasts", lasting(found)), ("onset of whirl", onset_text(found)),
                ("whirl frequency", frequency_text(found)), ("largest radius", ", ".join(radii)),
                *(("note", note) for note in self.notes)]  # fmt: skip
        return Table((), rows, title=f"Whirl of {', '.join(self.marks) or 'no mark'}: {self.time.size} samples")

    def _timeline(self, periods: tuple[MotionPeriod, ...]) -> list[dict[str, Any]]:
        end = float(self.time[-1]) if self.time.size else 0.0
        return [{**line, "state": line["state"].value} for line in timeline(periods, end)]


def analyze(
    time: ArrayLike,
    x: ArrayLike,
    y: ArrayLike,
    rotation: ArrayLike | str,
    *,
    clearance: Quantity | None = None,
    radius: Quantity = 0.0,
    spin: ArrayLike | None = None,
    on: Literal["centre", "wall"] = "centre",
    names: Sequence[str] = (),
) -> Whirl:
    """Find whirl in measured positions: onset, precession, motion states.

    Args:
        time: Times [s], rising, shape (T,).
        x: Position across the hole, from its axis [m], shape (T,) for one mark or (T, m); NaN where not seen.
        y: The other coordinate, a quarter turn counter-clockwise from x seen from above, as x.
        rotation: Speed of the top drive [rad/s], shape (T,) or one value; or text such as "120 rpm". Positive is
            counter-clockwise seen from above.
        clearance: Distance the centre line can move before the string touches the wall [m]. Left out, the largest
            distance in the record is taken, and `notes` says so.
        radius: Outer radius of the string at the marks [m]; 0 where unknown, rolling then has no criterion.
        spin: Angle of the string's section [rad], wrapped or not, shape (T,) or (T, m), if measured.
        on: Place of the marks: on the centre line, or on the wall of the string at `radius`.
        names: Names of the marks; by default `mark_1`, `mark_2` ...

    Raises:
        AnalysisError: Arrays whose shapes do not fit, times that do not rise, nothing finite.
        ArgumentError: A quantity of another dimension.
    """
    times = _times(time)
    across, other = (_columns(name, values, times.size) for name, values in (("x", x), ("y", y)))
    if across.shape != other.shape:
        raise AnalysisError(f"x, y: expected arrays of one shape, found {across.shape} and {other.shape}")
    position = np.stack((across, other), axis=-1)
    marks, speed = position.shape[1], _speed(rotation, times.size)
    angle = None if spin is None else np.broadcast_to(_columns("spin", spin, times.size), (times.size, marks))
    reach = np.hypot(position[..., 0], position[..., 1])
    if not np.isfinite(reach).any():
        raise AnalysisError("x, y: expected positions [m], found none finite; give the positions of a mark")
    notes = () if clearance is not None else (CLEARANCE_TAKEN,)
    free = float(np.nanmax(reach)) if clearance is None else in_si("clearance", clearance, LENGTH)
    outer = in_si("radius", radius, LENGTH)
    labels = tuple(names) or tuple(f"mark_{k + 1}" for k in range(marks))
    if len(labels) != marks:
        raise AnalysisError(f"names: expected {marks}, one for each column of x, found {len(labels)}")
    analyzer = Analyzer([MarkInfo(name, float(k), on, outer, free) for k, name in enumerate(labels)])
    found = analyzer.push_block(np.rint(times * NANOSECONDS).astype(np.int64), position, angle, speed)
    summary = analyzer.summary()
    radii, precession, ratio, confidence = np.moveaxis(found.values, -1, 0)
    return Whirl(times, labels, radii, precession, ratio, confidence, summary, (*summary.notes, *notes))


def _times(time: ArrayLike) -> Array:
    times = _numbers("time", time)
    if times.ndim != 1 or times.size < 2:
        raise AnalysisError(f"time: expected at least two times, shape (T,), found an array of shape {times.shape}")
    wrong = ~(np.abs(times) <= LATEST)
    wrong[1:] |= ~(np.diff(times) > 0.0)
    if wrong.any():
        place = int(np.argmax(wrong))
        raise AnalysisError(
            f"time: expected finite times [s] within {LATEST:.3g} s of zero, each above the one before, found "
            f"{times[place]:g} at index {place}; sort the record, drop repeated samples, divide milliseconds by 1000"
        )
    return times


def _columns(name: str, values: ArrayLike, samples: int) -> Array:
    array = _numbers(name, values)
    array = array[:, None] if array.ndim == 1 else array
    if array.ndim != 2 or array.shape[0] != samples or array.shape[1] == 0:
        raise AnalysisError(
            f"{name}: expected shape ({samples},) or ({samples}, m) as time has {samples} samples, "
            f"found {np.shape(values)}; give one row a time"
        )
    return array


def _speed(rotation: ArrayLike | str, samples: int) -> Array:
    speed = _numbers("rotation", in_si("rotation", rotation, ANGULAR_SPEED) if isinstance(rotation, str) else rotation)
    if speed.shape not in {(), (samples,)}:
        raise AnalysisError(
            f"rotation: expected one speed [rad/s] or shape ({samples},), found shape {speed.shape}; "
            "interpolate it to the times of the positions"
        )
    return np.broadcast_to(speed, samples)


def _numbers(name: str, values: ArrayLike) -> Array:
    try:
        return np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise AnalysisError(f"{name}: expected numbers, found {error}; give a plain array") from error
