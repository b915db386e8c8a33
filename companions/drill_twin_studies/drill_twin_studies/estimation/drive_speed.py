# SPDX-License-Identifier: Apache-2.0
"""Measured speed of the top drive beside its set-point, where the speed is not a channel that corrects."""

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array

_RPM = 30.0 / np.pi
"""Revolutions a minute of 1 rad/s."""
_MEAN = 10.0
"""Time of a mean speed [s]: a cycle of stick-slip, which a soft drive lets through, takes 2 to 8 s; chosen, not
measured."""
_SETTLE = 10.0
"""Time from a change of the set-point to the first sample of a mean [s]; chosen, not measured."""
_CHANGED, _APART = 0.01, 0.05
"""Shares of the set-point by which it counts as changed, and by which the drive turns at another speed; chosen."""


class DriveSpeed:
    """Mean measured speed of the top drive over the last `_MEAN` seconds of a set-point that stays.

    The members turn as the set-point says. So where the drive turns otherwise, their numbers are bent without an alarm.
    """

    def __init__(self) -> None:
        self._set_point, self._since = float("nan"), 0.0
        self._samples: deque[tuple[float, float]] = deque()

    def take(self, ends: float, rotation: Array, samples: Sequence[tuple[float, Mapping[str, float]]]) -> None:
        """Take a window.

        Args:
            ends: Time of its end [s].
            rotation: Set-point at the end of each frame [rad/s], shape (F,).
            samples: Time [s] and values by name of each sample.
        """
        if not np.all(np.abs(rotation - self._set_point) <= _CHANGED * abs(self._set_point)):
            self._set_point, self._since = float(rotation[-1]), ends
            self._samples.clear()
        for time, values in samples:
            if time > self._since + _SETTLE and np.isfinite(speed := values.get("top_drive_speed", np.nan)):
                self._samples.append((time, speed))
        while self._samples and self._samples[0][0] < ends - _MEAN:
            self._samples.popleft()

    @property
    def told(self) -> str:
        """Sentence on a drive that does not turn at its set-point; empty where it does, or where it is not known."""
        if not self._samples or self._samples[-1][0] - self._samples[0][0] < 0.8 * _MEAN:
            return ""
        mean = float(np.mean([speed for _, speed in self._samples]))
        if abs(mean - self._set_point) <= _APART * abs(self._set_point):
            return ""
        return (
            f"the top drive turns at {mean * _RPM:.4g} rpm and its set-point is {self._set_point * _RPM:.4g} rpm: the "
            "members turn at the set-point, so their numbers are bent; with `set_points: measured` they turn as the rig"
        )
