# SPDX-License-Identifier: Apache-2.0
"""Windows from the samples of a rig, which may be late, missing, repeated, frozen or absurd, or jump in time."""

import math
from collections import Counter, deque
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Sub
from drill_twin.scene.set_points import Command, Schedule
from drill_twin_studies.estimation.drive_speed import DriveSpeed
from drill_twin_studies.estimation.estimate import REACH, FilterWindow, WindowTiming
from drill_twin_studies.estimation.subs import SubIntake

SET_POINTS = Command._fields
"""Names of the set-points among the values of a sample [N], [rad/s], [m/s]: the fields of `Command`."""
_GAP = 5.0
"""Time without a sample [s] that is followed without measurement; a longer time is a jump of the clock; not
measured."""
_BACK = 1.0
"""Time by which a stamp may lie behind the newest one [s] to count as late; a stamp farther back is a jump of the
clock; not measured."""
_ROUND_OFF = 2e-6
"""Error of times [s]: a double that counts seconds from 1970 is exact to 0.2 us, and differences are rounded to 1
us."""
_USUAL = 20
"""Last samples of a channel, whose median distance is the usual time from sample to sample."""
_LOST = 1.5
"""Distance of two samples over the usual one, from which a sample between is lost: half-way between one and two."""
_FROZEN = 3.0
"""Time for which a channel that used to change has one value, after which it is frozen [s], over more than `_FEWEST`
samples; not measured."""
_FEWEST = 8
"""Samples in a window from which single samples can be told to be absurd; not measured."""
_SPREADS = 15.0
"""Robust standard deviations from the median, added to `_SHARE` of the largest value, beyond which a sample is absurd;
not measured."""
_SHARE = 0.05
_MOST = 0.15
"""Largest share of absurd samples in a window: more are no error of single samples; not measured."""
Sample = tuple[float, Mapping[str, float]]
"""Time [s] and values by name."""


class Intake:
    """Intake of samples, which become windows of time.

    A sample is a mean over the time since the sample before it, or over the usual time where the sample before is lost.
    The weights of a window say over which frames of the model the mean is, so a sample may have any stamp.

    Attributes:
        troubles: Number of samples, windows or jumps by kind of trouble.
        frozen: Channels that are frozen.
        ready: Whole windows that wait.
        origin: Stamp [s] of time zero of the windows; None before the first sample.
        drive: Measured speed of the top drive beside its set-point.
    """

    def __init__(
        self,
        pace: WindowTiming,
        scene: Scene,
        channels: Sequence[str],
        subs: Sequence[Sub] = (),
        instant: Collection[str] = (),
    ) -> None:
        self.troubles: Counter[str] = Counter()
        self.frozen: set[str] = set()
        self.drive = DriveSpeed()
        self._pace, self._channels, self._instant = pace, list(channels), instant
        self._schedule = Schedule.from_scene(scene)
        self.origin: float | None = None
        self._start = 0.0  # of the open window
        self._past = {name: deque[float](maxlen=_USUAL) for name in channels}  # times of the last samples of a channel
        self._newest = 0.0
        self._open: list[Sample] = []
        self._held: dict[str, tuple[float, float]] = {}  # last set-points, with their times
        self._last: dict[str, tuple[float, float, int]] = {}  # last new value of a channel, when it came, how often
        self._varied: set[str] = set()
        self._largest: dict[str, float] = {}
        self.ready: deque[FilterWindow] = deque()
        self._subs = [SubIntake(pace, sub, self.troubles) for sub in subs]

    def take(self, stamp: float, values: Mapping[str, float]) -> bool:
        """Take a sample; returns False for a stamp that cannot be used: late, repeated or not finite.

        Args:
            stamp: Time of the sample [s], of any clock.
            values: Values by channel, or by name of `SET_POINTS`; NaN for what the sample does not have.
        """
        if not math.isfinite(stamp):
            self.troubles["stamp not finite"] += 1
            return False
        if self.origin is None:
            self.origin = stamp
        time = round(stamp - self.origin, 6)
        if time > self._newest + _GAP or time < self._newest - _BACK:
            self.troubles["clock jump"] += 1
            self.origin += time - self._newest  # time goes on from where it was
            time = self._newest
        elif abs(time - self._newest) < _ROUND_OFF and self._open:
            self.troubles["repeated"] += 1
            return False
        while time > self._start + self._pace.window + _ROUND_OFF:
            self._close((time, values))
        if time <= self._start + _ROUND_OFF and self._start > 0.0:
            self.troubles["late"] += 1
            return False
        self._newest = max(self._newest, time)
        self._open.append((time, values))
        return True

    def take_readings(self, stamp: float, sub: int, values: Sequence[float]) -> None:
        """Take a reading of a downhole sub; the surface channels alone move the time of the windows.

        Args:
            stamp: Time of the reading [s], of the same clock as the stamps of `take`.
            sub: Number of the sub.
            values: Specific force [m/s^2] and rates of rotation [rad/s], six values.
        """
        if self.origin is None:
            return
        time = stamp - self.origin
        if not time > self._start or time > self._newest + _GAP:
            self.troubles["reading out of time"] += 1
            return
        self._subs[sub].take(time, values)

    def window(self) -> FilterWindow | None:
        """The next whole window, if there is one."""
        return self.ready.popleft() if self.ready else None

    def skip(self) -> None:
        """Leave out the oldest window that waits."""
        self.ready.popleft()
        self.troubles["skipped window"] += 1

    def _close(self, following: Sample) -> None:
        """Close the open window, at the first sample after it."""
        samples = sorted(self._open, key=lambda sample: sample[0])
        self._open = []
        ends: Array = self._start + self._pace.period * np.arange(1.0, self._pace.frames + 1.0)
        commands = np.stack([self._set_points(name, samples, following, ends) for name in SET_POINTS], axis=1)
        self.drive.take(self._start + self._pace.window, commands[:, SET_POINTS.index("rotation")], samples)
        parts = {name: self._compared(name, samples) for name in self._channels}
        readings = np.array([sub.close(self._start) for sub in self._subs])
        usual = {name: time for name in self._channels if math.isfinite(time := self._usual(name))}
        overdue = following[0] - self._newest > _LOST * min([REACH, *usual.values()])
        if not samples and overdue:
            self.troubles["missing window"] += 1
        self._start += self._pace.window
        self.ready.append(
            FilterWindow(
                commands=commands,
                measured={name: measured for name, (measured, _) in parts.items()},
                weights=np.array([weights for _, weights in parts.values()]),
                readings=readings if self._subs else None,
                spacing=min((time for name, time in usual.items() if name != "hookload"), default=math.nan),
                between=not samples and not overdue,
            )
        )

    def _set_points(self, name: str, samples: Sequence[Sample], following: Sample, ends: Array) -> Array:
        """Set-point at the end of each frame: linear between given set-points, and held after the last one."""
        given = [(time, values[name]) for time, values in samples if math.isfinite(values.get(name, math.nan))]
        if name not in self._held and not given:
            return self._schedule.over(ends.tolist())[:, SET_POINTS.index(name)]
        points = [self._held[name], *given] if name in self._held else given
        self._held[name] = points[-1]
        if math.isfinite(after := following[1].get(name, math.nan)):
            points = [*points, (following[0], after)]
        time, value = np.array(points).T
        return np.asarray(np.interp(ends, time, value))

    def _usual(self, name: str) -> float:
        """Usual time from sample to sample of a channel [s]; NaN where it is not known yet."""
        return float(np.median(np.diff(self._past[name]))) if len(self._past[name]) > 1 else math.nan

    def _compared(self, name: str, samples: Sequence[Sample]) -> tuple[Array, Array]:
        """Samples of a channel in the window, and weights of the frames, as of `FilterWindow`.

        Where there are more than the window has room for, neighbours are averaged: both what is measured and the time
        in which it was.
        """
        pace, past = self._pace, self._past[name]
        found = np.array([(time, values.get(name, math.nan)) for time, values in samples]).reshape(-1, 2)
        time, value = found[np.isfinite(found[:, 1])].T
        distance = np.diff(time, prepend=past[-1] if past else math.nan)
        past.extend(time.tolist())
        usual = self._usual(name)
        length = np.where(distance <= _LOST * usual, distance, usual)
        if name in self._instant:
            length[:] = pace.period
        self.troubles += Counter({f"mean of more than {REACH:g} s": int(np.count_nonzero(length > REACH))})
        sound = self._sound(name, value) & np.less_equal(length, REACH) & np.greater(time - length, -_ROUND_OFF)
        time, value, length = time[sound], value[sound], length[sound]
        if self._is_frozen(name, time, value):
            time, value, length = time[:0], value[:0], length[:0]
        edges = self._start + pace.period * np.arange(-pace.tail, pace.frames + 1.0)
        within = np.diff(np.clip(edges, (time - length)[:, None], time[:, None]), axis=1)
        place = np.arange(time.size) * pace.samples // max(time.size, pace.samples)
        weights, total = np.zeros((pace.samples, edges.size - 1)), np.bincount(place, length, pace.samples)
        np.add.at(weights, place, within)
        with np.errstate(invalid="ignore"):
            measured = np.bincount(place, length * value, pace.samples) / total
            return measured, np.nan_to_num(weights / weights.sum(axis=1, keepdims=True)).T

    def _sound(self, name: str, values: Array) -> Array:
        """Mask of the values that are not absurd beside the others of the window (Hampel's identifier)."""
        if values.size < _FEWEST:
            return np.ones(values.size, dtype=bool)
        middle = np.median(values)
        spread = 1.4826 * np.median(np.abs(values - middle))
        size = self._largest.get(name, float(np.abs(middle)))
        sound = np.abs(values - middle) <= _SPREADS * spread + _SHARE * size
        if np.count_nonzero(~sound) > _MOST * values.size:
            sound[:] = True
        self.troubles += Counter(absurd=int(np.count_nonzero(~sound)))
        self._largest[name] = max(size, float(np.abs(values[sound]).max()))
        return np.asarray(sound)

    def _is_frozen(self, name: str, time: Array, value: Array) -> bool:
        """True for a channel that used to change and has had one value for some time and samples."""
        for at, new in zip(time.tolist(), value.tolist(), strict=True):
            old, since, count = self._last.get(name, (new, at, 0))
            if old != new:
                self._varied.add(name)
            self._last[name] = (new, at, 1) if old != new else (new, since, count + 1)
        _, since, count = self._last.get(name, (0.0, math.inf, 0))
        is_frozen = name in self._varied and time.size > 0 and time[-1] - since >= _FROZEN and count > _FEWEST
        if is_frozen and name not in self.frozen:
            self.troubles["frozen"] += 1
        (self.frozen.add if is_frozen else self.frozen.discard)(name)
        return bool(is_frozen)
