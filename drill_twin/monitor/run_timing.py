# SPDX-License-Identifier: Apache-2.0
"""Computing time of a run, in total and by effect; for the diagnostics."""

from __future__ import annotations

from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin


class RunTiming:
    """Real-time factor and step counts, over the whole run and since the last report."""

    def __init__(self) -> None:
        # Simulated, computing and publishing time [s].
        self._total = [0.0, 0.0, 0.0]
        self._window = [0.0, 0.0, 0.0]
        self._steps = self._iterations = self._cut = self._loose = 0
        self._window_iterations = 0
        self._slowest = 0.0

    def update(self, simulated: float, computing: float, publishing: float, frame: Frame) -> None:
        """Count one frame with its simulated, computing and publishing time [s]."""
        for times in (self._total, self._window):
            times[0] += simulated
            times[1] += computing
            times[2] += publishing
        self._steps += frame.stats.steps
        self._iterations += frame.stats.iterations
        self._window_iterations += frame.stats.iterations
        self._cut += frame.stats.cut_steps
        self._loose += frame.stats.loose_steps
        self._slowest = max(self._slowest, computing)

    def start_window(self) -> None:
        """Start a new reporting window."""
        self._window = [0.0, 0.0, 0.0]
        self._window_iterations = 0

    @property
    def seconds_per_iteration(self) -> float:
        """Computing time over Newton iterations in this window [s]; 0 without an iteration."""
        return self._window[1] / self._window_iterations if self._window_iterations else 0.0

    @property
    def realtime_factor(self) -> float:
        """Simulated time over computing time; 0 before the first frame."""
        return _factor(self._total)

    def values(self) -> dict[str, str]:
        """Diagnostics values. The real-time factor is simulated time over the computing time of the physics."""
        simulated, _, publishing = self._total
        return {
            "realtime_factor": f"{self.realtime_factor:.3f}",
            "realtime_factor_last_second": f"{_factor(self._window):.3f}",
            "slowest_frame_ms": f"{self._slowest * 1e3:.3f}",
            "publishing_share": f"{publishing / simulated if simulated else 0.0:.4f}",
            "steps": str(self._steps),
            "iterations": str(self._iterations),
            "cut_steps": str(self._cut),
            "loose_steps": str(self._loose),
        }

    def text(self) -> str:
        """The real-time factor as a sentence."""
        factor = self.realtime_factor
        return f"physics runs {factor:.1f} times as fast as real time" if factor else "nothing simulated yet"


def _factor(times: list[float]) -> float:
    simulated, computing, _ = times
    return simulated / computing if computing else 0.0


class EffectTiming:
    """Share of each effect in the computing time of a step.

    Sampled: each report times the functions of one effect alone, in the present configuration of the string, and
    relates the times of all to that of a Newton iteration. The remainder is the rod and the solution of its equations.
    An effect that causes more Newton iterations costs more than its functions do: `drill-twin effects` measures that by
    leaving it out.
    """

    def __init__(self, twin: Twin) -> None:
        """Compile the timing functions and time every effect once."""
        self._measure = twin.effect_timer()
        self._seconds = {name: self._measure(name) for name in twin.effects}
        self._next = 0

    def values(self, seconds_per_iteration: float) -> dict[str, str]:
        """Diagnostics values; times the next effect. Empty if there is no effect, or no iteration to relate to.

        Args:
            seconds_per_iteration: Present computing time of a Newton iteration [s].
        """
        names = list(self._seconds)
        if not names or not seconds_per_iteration:
            return {}
        name = names[self._next % len(names)]
        self._next += 1
        self._seconds[name] = self._measure(name)
        shares = {name: seconds / seconds_per_iteration for name, seconds in self._seconds.items()}
        values = {f"step_cost_{name}": f"{share:.4f}" for name, share in shares.items()}
        return {**values, "step_cost_rod_and_solution": f"{max(1.0 - sum(shares.values()), 0.0):.4f}"}
