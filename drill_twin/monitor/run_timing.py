# SPDX-License-Identifier: Apache-2.0
"""What simulating costs, for the diagnostics of a node and of a run without ROS."""

from __future__ import annotations

from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin


class RunTiming:
    """What simulating costs: over the last second and over all."""

    def __init__(self) -> None:
        self._all = [0.0, 0.0, 0.0]
        self._window = [0.0, 0.0, 0.0]
        self._steps = self._iterations = self._cut = self._loose = 0
        self._window_iterations = 0
        self._slowest = 0.0

    def add(self, simulated: float, computing: float, publishing: float, frame: Frame) -> None:
        """Count one frame; all in seconds."""
        for total in (self._all, self._window):
            total[0] += simulated
            total[1] += computing
            total[2] += publishing
        self._steps += frame.stats.steps
        self._iterations += frame.stats.iterations
        self._window_iterations += frame.stats.iterations
        self._cut += frame.stats.cut_steps
        self._loose += frame.stats.loose_steps
        self._slowest = max(self._slowest, computing)

    def next_window(self) -> None:
        """Begin a new second."""
        self._window = [0.0, 0.0, 0.0]
        self._window_iterations = 0

    @property
    def iteration(self) -> float:
        """What a Newton iteration has cost in the last second, all that a step needs included [s]; 0 without one."""
        return self._window[1] / self._window_iterations if self._window_iterations else 0.0

    @staticmethod
    def _factor(total: list[float]) -> float:
        return total[0] / total[1] if total[1] else 0.0

    @property
    def factor(self) -> float:
        """Simulated time over the time spent on the physics; 0 before the first frame."""
        return self._factor(self._all)

    def values(self) -> dict[str, str]:
        """For the diagnostics. The real-time factor is simulated time over the time spent on the physics."""
        simulated, _, publishing = self._all
        return {
            "realtime_factor": f"{self._factor(self._all):.3f}",
            "realtime_factor_last_second": f"{self._factor(self._window):.3f}",
            "slowest_frame_ms": f"{self._slowest * 1e3:.3f}",
            "publishing_share": f"{publishing / simulated if simulated else 0.0:.4f}",
            "steps": str(self._steps),
            "iterations": str(self._iterations),
            "cut_steps": str(self._cut),
            "loose_steps": str(self._loose),
        }

    def sentence(self) -> str:
        """The cost in words."""
        factor = self._factor(self._all)
        return f"physics runs {factor:.1f} times as fast as real time" if factor else "nothing simulated yet"


class EffectTiming:
    """Which share of the cost of a step goes with which effect.

    Sampled, not counted: each effect's functions are timed alone at the present shape of the string, one effect a
    second, and put in relation to what an iteration has cost in that second. The rest is the rod and the solution of
    its equations. An effect that makes Newton iterate more often costs more than its functions do: `drill-twin effects`
    measures that by leaving it out.
    """

    def __init__(self, twin: Twin) -> None:
        """Compile what times the effects, and time all of them once."""
        self._price = twin.meter()
        self._prices = {name: self._price(name) for name in twin.effects}
        self._next = 0

    def values(self, iteration: float) -> dict[str, str]:
        """For the diagnostics, once for each report.

        Args:
            iteration: What an iteration costs now [s].
        """
        names = list(self._prices)
        if not names or not iteration:
            return {}
        name = names[self._next % len(names)]
        self._next += 1
        self._prices[name] = self._price(name)
        shares = {name: price / iteration for name, price in self._prices.items()}
        values = {f"step_cost_{name}": f"{share:.4f}" for name, share in shares.items()}
        return {**values, "step_cost_rod_and_solution": f"{max(1.0 - sum(shares.values()), 0.0):.4f}"}
