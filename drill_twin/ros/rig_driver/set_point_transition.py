# SPDX-License-Identifier: Apache-2.0
"""From set-points in force to another plan of them in mid-run, without a jump."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drill_twin.schedule.command import Command

Plan = Callable[[float], Command]
"""Simulated time [s] -> set-points."""


@dataclass(frozen=True)
class SetPointTransition:
    """A plan that is reached by a cubic step, flat at both ends (the STEP of the schedules)."""

    before: Command
    """What was in force."""
    after: Plan
    """What holds afterwards."""
    start: float
    """Simulated time at which the change begins [s]."""
    duration: float
    """How long it takes [s]."""

    def __call__(self, time: float) -> Command:
        """Set-points at a time [s]."""
        passed = (time - self.start) / self.duration if self.duration > 0.0 else 1.0
        if passed >= 1.0:
            return self.after(time)
        share = max(passed, 0.0) ** 2 * (3.0 - 2.0 * max(passed, 0.0))
        old, new = self.before, self.after(time)
        return Command(
            old.weight_on_bit + share * (new.weight_on_bit - old.weight_on_bit),
            old.rotation + share * (new.rotation - old.rotation),
        )
