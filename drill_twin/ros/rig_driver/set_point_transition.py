# SPDX-License-Identifier: Apache-2.0
"""Transition from the set-points in force to another plan during a run, without a jump."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drill_twin.scene.set_points.command import Command

Plan = Callable[[float], Command]
"""Simulated time [s] -> set-points."""


@dataclass(frozen=True)
class SetPointTransition:
    """Plan that is reached by a cubic step with zero slope at both ends (the STEP of the schedules)."""

    before: Command
    """Set-points in force before."""
    after: Plan
    """Plan that holds afterwards."""
    start: float
    """Simulated time at the start of the transition [s]."""
    duration: float
    """Duration of the transition [s]."""

    def __call__(self, time: float) -> Command:
        """Set-points at a time [s]."""
        passed = (time - self.start) / self.duration if self.duration > 0.0 else 1.0
        if passed >= 1.0:
            return self.after(time)
        share = max(passed, 0.0) ** 2 * (3.0 - 2.0 * max(passed, 0.0))
        return self.before.mixed(self.after(time), share)
