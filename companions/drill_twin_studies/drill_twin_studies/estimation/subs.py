# SPDX-License-Identifier: Apache-2.0
"""Lateral motion of the members, and readings of downhole subs: in a member, from a rig, and as features to compare.

The force that a sub reads is a mean over a frame, with impacts in it. Its integral, turned out of the frame of the sub
by the gyroscope of the sub, is smooth: it is the lateral velocity but for a constant. The mean of the velocity is left
out, and so is the mean of the force in the frame of the sub, which has the bias of the accelerometers. Readings of the
rig and of the members are treated alike.
"""

import math
from collections import Counter
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.sensors.motion import SubMotion, locate, sub_motion, true_readings
from drill_twin.dynamics.sensors.subs import REAL, gravity_of, places_of, subs_by_name
from drill_twin.dynamics.twin.frame_record import FrameSeries, NodeSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Sub
from drill_twin_studies.estimation.estimate import WindowTiming

VALUES = 6
"""Values of a reading: specific force [m/s^2] and rates of rotation [rad/s] about the axes of the sub."""
_ABSURD = 10.0
"""Force over the largest force of a member in a window, from which a reading that is rare is absurd; not measured."""
_RARE = 0.1
"""Share of the frames of a window below which large readings are rare; not measured."""


def listed(scene: Scene, names: Sequence[str]) -> list[Sub]:
    """Subs of a scene by name, `measured/NAME` for a sub of a real rig.

    Raises:
        ArgumentError: The scene does not list a sub, or a sub is named twice.
    """
    known = subs_by_name(scene)
    wanted = [name.removeprefix(REAL) for name in names]
    if odd := [name for name, sub in zip(names, wanted, strict=True) if sub not in known or wanted.count(sub) > 1]:
        raise ArgumentError(
            f"subs: expected each once, of the subs that scene {scene.name} lists ({', '.join(known) or 'none'}), "
            f"found {', '.join(odd)}; list it under `sensors.subs` of the scene, or with --set"
        )
    return [known[name] for name in wanted]


class SubReader:
    """Perfect readings of subs in a twin."""

    def __init__(self, scene: Scene, twin: Twin, subs: Sequence[Sub]) -> None:
        places = places_of(subs, twin.rod)
        self._nodes = np.unique(np.concatenate((places.element, places.element + 1)))
        self._places = places._replace(element=np.searchsorted(self._nodes, places.element))
        self._gravity = gravity_of(scene)

    def start(self, twin: Twin) -> tuple[Array, Array]:
        """Node rows that carry the subs, before a window."""
        u, v = twin.unknowns
        return u[self._nodes], v[self._nodes]

    def read(self, before: tuple[Array, Array], states: NodeSeries, period: float) -> Array:
        """Means over the frames of a window, shape (F, s, 6).

        Args:
            before: As `start` returned them.
            states: The recorded frames.
            period: Length of a frame [s].
        """
        rows = (np.concatenate((w[None], part[:, self._nodes])) for w, part in zip(before, states[:2], strict=True))
        motion = sub_motion(self._places, *rows)
        first, last = SubMotion(*(part[:-1] for part in motion)), SubMotion(*(part[1:] for part in motion))
        return true_readings(self._places, first, last, period, self._gravity)


def replace_outliers(measured: Array, predicted: Array) -> Array:
    """Readings of a rig, in which the reading before stands for a rare reading that is absurd beside the members'.

    Args:
        measured: Shape (s, F, 6); NaN for a sub without readings.
        predicted: Readings of the members, shape (N, F, s, 6).
    """
    force = np.abs(measured[..., :3]).max(axis=2)
    largest = np.abs(predicted[..., :3]).max(axis=(0, 1, 3))
    off: Mask = force > _ABSURD * np.maximum(largest, 1.0)[:, None]
    off &= off.mean(axis=1, keepdims=True) < _RARE
    row = np.where(off, 0, np.arange(force.shape[1]))
    return np.take_along_axis(measured, np.maximum.accumulate(row, axis=1)[..., None], axis=1)


def lateral_velocity(readings: Array, period: float, samples: int) -> ComplexArray:
    """Lateral velocity about its mean, of means over the samples, shape (..., S) [m/s].

    Its direction is counted from the sensor's direction at the start of the window.

    Args:
        readings: Shape (..., F, 6).
        period: Length of a frame [s].
        samples: Samples S of the F frames.
    """
    force = readings[..., 0] + 1j * readings[..., 1]
    spin = period * (np.cumsum(readings[..., 5], axis=-1) - 0.5 * readings[..., 5])
    steady = force - force.mean(axis=-1, keepdims=True)
    velocity = period * np.cumsum(steady * np.exp(1j * spin), axis=-1)
    means = _means(velocity, samples)
    return np.asarray(means - means.mean(axis=-1, keepdims=True))


def _means(values: NDArray[Any], samples: int) -> NDArray[Any]:
    return np.asarray(values.reshape(*values.shape[:-1], samples, values.shape[-1] // samples).mean(axis=-1))


def speed(readings: Array, samples: int) -> Array:
    """Speed of rotation, of means over the samples, shape (..., S) [rad/s]."""
    return _means(readings[..., 5], samples)


def velocity_noise(sub: Sub, window: float) -> float:
    """Standard deviation that the noise of the accelerometers leaves in `lateral_velocity` [m/s].

    A random walk whose ends are tied by the removal of the mean has this deviation half-way between them.
    """
    return 0.5 * sub.accelerometer.noise * math.sqrt(window / sub.rate)


_LARGEST = 1e5
"""Largest reading where the scene gives no range: 10 000 g."""
_GAP = 3.5
"""Intervals between readings over which readings are interpolated; a window with a longer gap goes without the sub."""
_FEWEST = 8
"""Readings of a window from which equal readings are frozen; not measured."""


class SubIntake:
    """Readings of a sub on their way to windows."""

    def __init__(self, pace: WindowTiming, sub: Sub, troubles: Counter[str]) -> None:
        self._pace, self._rate, self._troubles = pace, sub.rate, troubles
        ranges = [sub.accelerometer.range or _LARGEST] * 3 + [sub.gyroscope.range or _LARGEST] * 3
        self._largest = np.array(ranges)
        self._open: dict[float, Array] = {}
        self._last: list[tuple[float, Array]] = []  # of the window before, or none

    def take(self, time: float, values: Sequence[float]) -> None:
        """Take a reading of six values, by its time in the ensemble [s]."""
        reading = np.asarray(values, float)
        if not np.all(np.abs(reading) <= self._largest):
            self._troubles["impossible reading"] += 1
        elif time in self._open:
            self._troubles["repeated reading"] += 1
        else:
            self._open[time] = reading

    def close(self, start: float) -> Array:
        """Readings at the middles of the frames of the window that starts at a time [s], shape (F, 6); NaN without."""
        pace, end = self._pace, start + self._pace.window
        middles = start + pace.period * (0.5 + np.arange(pace.frames))
        given = sorted(self._open.items(), key=itemgetter(0))
        own, after = [each for each in given if each[0] <= end], [each for each in given if each[0] > end]
        points = [*self._last, *own, *after[:1]]
        self._open, self._last = dict(after), own[-1:] or self._last
        times = np.array([time for time, _ in points])
        gaps = np.diff(np.clip(times, start, end), prepend=start, append=end)
        if not own or gaps.max() > _GAP / self._rate:
            self._troubles["window without readings"] += 1
        elif len(own) >= _FEWEST and not np.ptp([values for _, values in own], axis=0).any():
            self._troubles["frozen readings"] += 1
        else:
            columns = np.array([values for _, values in points]).T
            return np.stack([np.interp(middles, times, column) for column in columns], axis=-1)
        return np.full((pace.frames, VALUES), np.nan)


_LEAST_TURN = 1.0
"""Revolutions that a window must have, to tell offset, synchronous part and the rest apart."""


def asynchronous_radius(rows: FrameSeries) -> Array:
    """Rms radius of z - c - S exp(i spin) at each mark over recorded frames [m], shape (m,); 0 within a revolution.

    Offset c and synchronous part S are a least-squares fit over the window; the analyzer's has a fading memory
    (`drill_twin.whirl.orbit.runout_separation`).
    """
    found = np.zeros(rows.spin.shape[1])
    for mark in range(found.size):
        spin = rows.spin[:, mark]
        if abs(spin[-1] - spin[0]) < 2.0 * np.pi * _LEAST_TURN:
            continue
        motion = rows.centre[:, mark, 0] + 1j * rows.centre[:, mark, 1]
        parts = np.column_stack((np.ones(spin.size), np.exp(1j * spin)))
        fitted = parts @ np.linalg.lstsq(parts, motion, rcond=None)[0]
        found[mark] = np.sqrt(np.mean(np.abs(motion - fitted) ** 2))
    return found


class LateralMotion:
    """Lateral motion of twins of one scene: places and slopes of the n + 1 nodes, and their velocities.

    Attributes:
        turns_freely: True if the motion may be turned about the axis of the hole, which is straight and vertical then.
    """

    def __init__(self, scene: Scene, twin: Twin) -> None:
        self._rod = rod = twin.rod
        self._spatial = twin.dynamics.form != LATERAL
        self._held_top = scene.rig.weight_on_bit.at != "top"
        self._clearance = np.array([scene.clearance_at(arc) for arc in rod.arc.tolist()])
        arcs = np.array([mark.distance_from_bit for mark in scene.string.marks])
        self._marks = locate(rod, arcs, np.zeros_like(arcs), np.zeros_like(arcs))
        self.turns_freely = not scene.hole.survey and not np.any(gravity_of(scene)[:2])

    def read(self, twins: Sequence[Twin]) -> ComplexArray:
        """Places and slopes, then their velocities, shape (N, 2, n + 1, 2)."""
        return np.array([[rows[:, (0, 3)] + 1j * rows[:, (1, 4)] for rows in twin.unknowns] for twin in twins])

    def marks(self, motion: ComplexArray) -> ComplexArray:
        """Places of the centre line at the marks [m], shape (N, m)."""
        low, shape = self._marks.element, self._marks.shape[:, 0]
        ends = np.concatenate((motion[:, 0, low], motion[:, 0, low + 1]), axis=-1)
        return np.asarray((shape * ends).sum(-1))

    def write(self, twins: Sequence[Twin], motion: ComplexArray) -> None:
        """Give the twins another lateral motion, as `read` returns it.

        Nodes stay in the hole. Stretch is kept, as the axial motion follows the lateral one within the time of a wave
        (a bent string is shorter): slopes z' keep the length of r', and nodes move along the hole as far as the string
        between them and the held end has become shorter.
        """
        before = self.read(twins)
        size = np.abs(motion[:, 0, :, 0])
        with np.errstate(divide="ignore", invalid="ignore"):
            motion[:, 0, :, 0] *= np.where(size > self._clearance, self._clearance / size, 1.0)
        for twin, old, new in zip(twins, before, motion, strict=True):
            for rows, values in zip(twin.unknowns, new, strict=True):
                rows[:, (0, 3)], rows[:, (1, 4)] = values.real, values.imag
            if self._spatial:
                rows = twin.unknowns[0]
                square = rows[:, 5] ** 2 + np.abs(old[0, :, 1]) ** 2 - np.abs(new[0, :, 1]) ** 2
                rows[:, 5] = np.copysign(np.sqrt(np.maximum(square, 0.0)), rows[:, 5])
                moved = np.append(0.0, np.cumsum(self._lost(old[0]) - self._lost(new[0])))
                rows[:, 2] += moved - moved[-1] if self._held_top else moved

    def _lost(self, motion: ComplexArray) -> Array:
        """Length of each element less its extent along the hole [m], of its places and slopes, shape (n,)."""
        slope = (self._rod.shape[:, :, 1] * np.hstack((motion[:-1], motion[1:]))[:, None]).sum(-1)
        cosine = np.sqrt(np.maximum(1.0 - np.abs(slope) ** 2, 0.0))
        return np.asarray(self._rod.length * np.mean(1.0 - cosine, axis=1))  # two Gauss points of equal weight
