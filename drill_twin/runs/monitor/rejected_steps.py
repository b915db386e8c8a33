# SPDX-License-Identifier: Apache-2.0
"""Frames that the step guard rejected and computed again, and the energy balance; for diagnostics and summary."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from drill_twin.dynamics.twin.frame import EnergyBalance, Frames
from drill_twin.runs.monitor.model_limits import SEPARATOR

ENERGY = "energy_"
"""Prefix of the keys of the energy balance, present where a scene asks for it: `energy_residual` is the share of
`energy_scale_J`, `energy_work_drag_J` the work of that effect."""
COUNT, NEW, STOP = "guard_interventions", "guard", "guard_stop"
"""Keys in the simulator's diagnostics: the count so far, those since the last report, and the reason of a stop."""
LARGEST_REPORT = 20
"""Largest number of rejected frames that one report describes."""
_LONGEST_COUNT = 18  # digits


class RejectedSteps:
    """Counts the frames that the step guard rejected.

    Attributes:
        count: Number of rejected frames.
        last: Description of the last one; empty if there is none.
        stopped: Reason of the stop; empty unless the run was stopped.
    """

    def __init__(self) -> None:
        self.count = 0
        self.last = self.stopped = ""
        self._new: list[str] = []
        self._energy: EnergyBalance | None = None

    def update(self, frames: Frames) -> None:
        """Count the rejected frames among some that were computed."""
        self._energy = frames.energy
        for intervention in frames.interventions:
            self.count += 1
            self.last = intervention.text
            self._new.append(self.last)

    def values(self) -> dict[str, str]:
        """Diagnostics values; each rejected frame is described in one report only."""
        described, remaining = self._new[:LARGEST_REPORT], len(self._new) - LARGEST_REPORT
        self._new = []
        if remaining > 0:
            described.append(f"and {remaining} more")
        values = {COUNT: str(self.count)}
        values |= {key: text for key, text in ((NEW, SEPARATOR.join(described)), (STOP, self.stopped)) if text}
        return values | (energy_values(self._energy) if self._energy else {})


def energy_values(energy: EnergyBalance) -> dict[str, str]:
    """Diagnostics values of an energy balance [J]."""
    parts = {"stored": energy.stored, "work": energy.work, "dissipated": energy.dissipated}
    values = {f"{kind}_{name}_J": value for kind, part in parts.items() for name, value in part.items()}
    values |= {"residual": energy.share, "scale_J": energy.scale, "newton_J": energy.newton}
    return {f"{ENERGY}{key}": repr(float(value)) for key, value in values.items()}


def is_count(text: str) -> bool:
    """Check that a text is a count; Python refuses to convert texts of thousands of digits."""
    return text.isdecimal() and len(text) <= _LONGEST_COUNT


class RecordedRejections:
    """Rejected frames and energy balance of a recorded run, read from the simulator's diagnostics.

    Attributes:
        count: Number of rejected frames.
        events: Their descriptions.
        stopped: Reason of the stop; None unless the run was stopped.
        energy: The last energy balance, by key.
    """

    def __init__(self) -> None:
        self.count = 0
        self.events: list[str] = []
        self.stopped: str | None = None
        self.energy: dict[str, float] = {}

    def update(self, values: Mapping[str, str]) -> None:
        """Read the values of one report."""
        self.count = int(values[COUNT]) if is_count(values.get(COUNT, "")) else self.count
        self.events += values[NEW].split(SEPARATOR) if values.get(NEW) else []
        self.stopped = values.get(STOP) or self.stopped
        found = {key.removeprefix(ENERGY): text for key, text in values.items() if key.startswith(ENERGY)}
        with suppress(ValueError):  # a bag of another program may use such a key
            self.energy |= {key: float(text) for key, text in found.items()}

    def summary(self) -> dict[str, object]:
        """Plain types for `summary.json`."""
        return {"interventions": self.count, "events": self.events, "stopped": self.stopped}
