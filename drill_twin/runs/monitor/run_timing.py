# SPDX-License-Identifier: Apache-2.0
"""Computing time of a run, for the diagnostics."""

from __future__ import annotations

import time

from drill_twin.dynamics.twin.frame import StepStats

_FRAMES, _SHORTEST = 10, 0.2  # a window of fewer frames and less time [s] has no rate


class RunTiming:
    """Real-time factor, speed of the physics and step counts, over the whole run and since the last report.

    The real-time factor is simulated over wall time, pauses left out. The speed of the physics is simulated time over
    the time spent computing the motion: the real-time factor of a run that did nothing else and waited for nothing.
    """

    def __init__(self) -> None:
        # Simulated, computing, publishing and wall time [s].
        self._total = [0.0, 0.0, 0.0, 0.0]
        self._steps = self._iterations = self._cut = self._loose = 0
        self._slowest = self._recent = 0.0
        self._frame_end: float | None = None
        self._window_start: float | None = None
        self._clear_window()

    def _clear_window(self) -> None:
        self._window_simulated, self._window_frames = 0.0, 0

    def update(self, simulated: float, publishing: float, stats: StepStats, frames: int = 1) -> None:
        """Count frames with their simulated and publishing time [s] in all, now that they are published.

        Args:
            simulated: Simulated time [s].
            publishing: Time of encoding and sending them [s].
            stats: Numerical effort.
            frames: Number of frames; those of a block count with their mean computing time.
        """
        now, computing = time.monotonic(), stats.wall_seconds
        start = now - computing - publishing if self._frame_end is None else self._frame_end
        self._frame_end = now
        self._window_start = start if self._window_start is None else self._window_start
        for k, seconds in enumerate((simulated, computing, publishing, now - start)):
            self._total[k] += seconds
        self._window_simulated += simulated
        self._window_frames += frames
        self._steps += stats.steps
        self._iterations += stats.iterations
        self._cut += stats.cut_steps
        self._loose += stats.loose_steps
        self._slowest = max(self._slowest, computing / frames)

    def pause(self) -> None:
        """Leave the time until the next frame out of the real-time factor of the run."""
        self._frame_end = None

    def start_window(self) -> None:
        """Start a new reporting window."""
        self._recent = self.recent_realtime_factor
        if self._window_start is not None:
            self._window_start = time.monotonic()
        self._clear_window()

    @property
    def simulated(self) -> float:
        """Simulated time [s]."""
        return self._total[0]

    @property
    def realtime_factor(self) -> float:
        """Simulated over wall time, pauses left out; 0 before the first frame."""
        return _ratio(self._total[0], self._total[3])

    @property
    def recent_realtime_factor(self) -> float:
        """Simulated over wall time in this window, or in the one before while this one is too short; 0 in a pause."""
        if self._window_start is None:
            return 0.0
        wall = time.monotonic() - self._window_start
        long_enough = self._window_frames >= _FRAMES or wall >= _SHORTEST
        return _ratio(self._window_simulated, wall) if long_enough else self._recent

    @property
    def physics_speed(self) -> float:
        """Simulated over computing time; 0 before the first frame."""
        return _ratio(self._total[0], self._total[1])

    def values(self) -> dict[str, str]:
        """Diagnostics values."""
        return {
            "realtime_factor": f"{self.realtime_factor:.3f}",
            "realtime_factor_last_second": f"{self.recent_realtime_factor:.3f}",
            "physics_speed": f"{self.physics_speed:.3f}",
            "slowest_frame_ms": f"{self._slowest * 1e3:.3f}",
            "publishing_share": f"{_ratio(self._total[2], self._total[0]):.4f}",
            "steps": str(self._steps),
            "iterations": str(self._iterations),
            "cut_steps": str(self._cut),
            "loose_steps": str(self._loose),
        }

    def text(self) -> str:
        """The real-time factor and the speed of the physics as a sentence."""
        if not self.simulated:
            return "nothing simulated yet"
        return f"real-time factor {self.realtime_factor:.3g}, the physics alone {self.physics_speed:.3g}"


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else 0.0
