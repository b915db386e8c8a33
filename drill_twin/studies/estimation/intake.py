# SPDX-License-Identifier: Apache-2.0
"""Windows from the samples of a rig: late, missing, repeated, frozen and absurd ones, and jumps of the clock."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Sub
from drill_twin.scene.set_points import Command, Schedule
from drill_twin.studies.estimation.estimate import FilterWindow
from drill_twin.studies.estimation.prediction import WindowTiming
from drill_twin.studies.estimation.subs import SubIntake

SET_POINTS = tuple(field.name for field in fields(Command))
"""Names of the set-points among the values of a sample [N], [rad/s], [m/s]; those of `Command`."""
_LONGEST_GAP = 5.0
"""Time without a sample [s] that is followed without measurement; a longer one is a jump of the clock."""
_BACK = 1.0
"""Time that a stamp may lie behind the newest one [s] and be late; farther back it is a jump of the clock."""
_ROUND_OFF = 2e-6
"""Error of times [s]: stamps are counted from 1970."""
_FROZEN = 3.0
"""Time after which a channel that used to change and does not is frozen [s]."""
_FEWEST = 8
"""Samples in a window from which single ones can be told to be absurd."""
_SPREADS = 15.0
"""Robust standard deviations from the median, and `_SHARE` of the largest value, beyond which a sample is absurd."""
_SHARE = 0.05
_MOST = 0.15
"""Largest share of absurd samples; more are no error of single samples."""


class Intake:
    """Makes windows of samples.

    Attributes:
        troubles: Number of samples, windows or jumps by kind of trouble.
        frozen: Channels that are frozen.
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
        self._pace, self._channels, self._instant = pace, list(channels), instant
        self._schedule = Schedule.from_scene(scene)
        self._origin: float | None = None  # stamp of time zero
        self._start = 0.0  # of the open window
        self._newest = 0.0
        self._open: list[tuple[float, Mapping[str, float]]] = []
        self._held: dict[str, tuple[float, float]] = {}  # last set-points, with their times
        self._last: dict[str, tuple[float, float]] = {}  # last new value of each channel, and when it came
        self._varied: set[str] = set()
        self._largest: dict[str, float] = {}
        self._ready: deque[FilterWindow] = deque()
        self._subs = [SubIntake(pace, sub, self.troubles) for sub in subs]

    @property
    def origin(self) -> float:
        """Stamp [s] of time zero of the windows; 0 before the first sample."""
        return self._origin or 0.0

    def take(self, stamp: float, values: Mapping[str, float]) -> bool:
        """Take a sample; returns False for one whose stamp cannot be used, as it is late, repeated or not finite.

        Args:
            stamp: Its time [s], of any clock.
            values: By channel or `SET_POINTS`; NaN for those that it does not have.
        """
        if not math.isfinite(stamp):
            self.troubles["stamp not finite"] += 1
            return False
        if self._origin is None:
            self._origin = stamp
        time = round(stamp - self._origin, 6)
        if time > self._newest + _LONGEST_GAP or time < self._newest - _BACK:
            self.troubles["clock jump"] += 1
            self._origin += time - self._newest  # time goes on from where it was
            time = self._newest
        elif abs(time - self._newest) < _ROUND_OFF and self._open:
            self.troubles["repeated"] += 1
            return False
        while time > self._start + self._pace.window + _ROUND_OFF:
            self._close()
        if time <= self._start + _ROUND_OFF and self._start > 0.0:
            self.troubles["late"] += 1
            return False
        self._newest = max(self._newest, time)
        self._open.append((time, values))
        return True

    def take_readings(self, stamp: float, sub: int, values: Sequence[float]) -> None:
        """Take a reading of a downhole sub; the surface channels alone move the time of the windows.

        Args:
            stamp: Its time [s], of the same clock as that of `take`.
            sub: Number of the sub.
            values: Specific force [m/s^2] and rates of rotation [rad/s], six values.
        """
        if self._origin is None:
            return
        time = stamp - self._origin
        if not time > self._start or time > self._newest + _LONGEST_GAP:
            self.troubles["reading out of time"] += 1
            return
        self._subs[sub].take(time, values)

    def window(self) -> FilterWindow | None:
        """The next whole window, if there is one."""
        return self._ready.popleft() if self._ready else None

    @property
    def waiting(self) -> int:
        """Whole windows that wait."""
        return len(self._ready)

    def skip(self) -> None:
        """Leave out the oldest window that waits."""
        self._ready.popleft()
        self.troubles["skipped window"] += 1

    def _close(self) -> None:
        samples = sorted(self._open, key=lambda sample: sample[0])
        self._open = []
        ends: Array = self._start + self._pace.period * np.arange(1.0, self._pace.frames + 1.0)
        if not samples:
            self.troubles["missing window"] += 1
        commands = np.stack([self._set_points(name, samples, ends) for name in SET_POINTS], axis=1)
        measured = {name: self._means(name, samples, ends) for name in self._channels}
        readings = np.array([sub.close(self._start) for sub in self._subs])
        self._start += self._pace.window
        self._ready.append(FilterWindow(commands, measured, readings if self._subs else None))

    def _set_points(self, name: str, samples: Sequence[tuple[float, Mapping[str, float]]], ends: Array) -> Array:
        """Set-point at the end of each frame: between those given linear, after the last one held."""
        given = [(time, values[name]) for time, values in samples if math.isfinite(values.get(name, math.nan))]
        if name not in self._held and not given:
            return self._schedule.over(ends.tolist())[:, SET_POINTS.index(name)]
        points = [self._held[name], *given] if name in self._held else given
        self._held[name] = points[-1]
        time, value = np.array(points).T
        held: Array = np.interp(ends, time, value)
        return held

    def _means(self, name: str, samples: Sequence[tuple[float, Mapping[str, float]]], ends: Array) -> Array:
        """Mean of a channel over each sample of the window; NaN where nothing sound was measured.

        Of a channel whose samples are instants: the value at the end of each, linear between those in the window.
        """
        found = np.array([(time, values.get(name, math.nan)) for time, values in samples]).reshape(-1, 2)
        found = found[np.isfinite(found[:, 1])]
        found = found[self._sound(name, found[:, 1])]
        if self._is_frozen(name, found):
            found = found[:0]
        edges = ends[:: self._pace.frames // self._pace.samples] - self._pace.period
        spacing = float(edges[1] - edges[0]) if edges.size > 1 else self._pace.window
        if name in self._instant and found.size:
            at = edges + spacing
            near = np.abs(at[:, None] - found[:, 0]).min(axis=1) < spacing - _ROUND_OFF
            return np.where(near, np.interp(at, found[:, 0], found[:, 1]), np.nan)
        place = np.maximum(np.searchsorted(edges, found[:, 0] - _ROUND_OFF, side="right") - 1, 0)
        count = np.bincount(place, minlength=self._pace.samples)
        total = np.bincount(place, found[:, 1], minlength=self._pace.samples)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

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

    def _is_frozen(self, name: str, found: Array) -> bool:
        """True for a channel that used to change and has had one value for some time."""
        for time, value in found.tolist():
            if name not in self._last or self._last[name][0] != value:
                if name in self._last:
                    self._varied.add(name)
                self._last[name] = value, time
        is_frozen = name in self._varied and found.size > 0 and float(found[-1, 0]) - self._last[name][1] >= _FROZEN
        if is_frozen and name not in self.frozen:
            self.troubles["frozen"] += 1
        (self.frozen.add if is_frozen else self.frozen.discard)(name)
        return is_frozen
