# SPDX-License-Identifier: Apache-2.0
"""What the guard did in a run, for diagnostics and summary."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from drill_twin.monitor.missing_effects import SEPARATOR
from drill_twin.twin.frame import EnergyBalance, Frame

ENERGY = "energy_"
"""Begins the keys of the energy balance, where a scene asks for it: `energy_residual` is the share of `energy_scale_J`,
`energy_work_drag_J` what that effect did."""
COUNT, NEW, STOP = "guard_interventions", "guard", "guard_stop"
"""Keys in the simulator's diagnostics: how many so far, those since the last report, and why the run was stopped."""
MOST = 20
"""Most interventions that one report tells of in words."""


class RejectedSteps:
    """Counts what the guard did.

    Attributes:
        count: How many frames were done again.
        last: The last one, in words; empty while there is none.
        stopped: Why the run was stopped; empty while it was not.
    """

    def __init__(self) -> None:
        self.count = 0
        self.last = self.stopped = ""
        self._new: list[str] = []
        self._energy: EnergyBalance | None = None

    def look(self, frame: Frame) -> None:
        """Take in one frame."""
        self._energy = frame.energy
        if frame.intervention is not None:
            self.count += 1
            self.last = frame.intervention.text
            self._new.append(self.last)

    def values(self) -> dict[str, str]:
        """For the diagnostics, once for each report: what is new is told once."""
        told, left = self._new[:MOST], len(self._new) - MOST
        self._new = []
        if left > 0:
            told.append(f"and {left} more")
        values = {COUNT: str(self.count), NEW: SEPARATOR.join(told), STOP: self.stopped}
        told_values = {key: value for key, value in values.items() if key == COUNT or value}
        return told_values | (energy_values(self._energy) if self._energy else {})


def energy_values(energy: EnergyBalance) -> dict[str, str]:
    """The energy balance for the diagnostics [J]."""
    parts = {"stored": energy.stored, "work": energy.work, "dissipated": energy.dissipated}
    values = {f"{kind}_{name}_J": value for kind, part in parts.items() for name, value in part.items()}
    values |= {"residual": energy.share, "scale_J": energy.scale, "newton_J": energy.newton}
    return {f"{ENERGY}{key}": repr(float(value)) for key, value in values.items()}


class GuardRecord:
    """The guard's part of a run, read from the simulator's diagnostics."""

    def __init__(self) -> None:
        self.count = 0
        self.events: list[str] = []
        self.stopped: str | None = None
        self.energy: dict[str, float] = {}

    def take(self, values: Mapping[str, str]) -> None:
        """Take in the values of one report."""
        self.count = int(values[COUNT]) if values.get(COUNT, "").isdecimal() else self.count
        self.events += values[NEW].split(SEPARATOR) if values.get(NEW) else []
        self.stopped = values.get(STOP) or self.stopped
        found = {key.removeprefix(ENERGY): text for key, text in values.items() if key.startswith(ENERGY)}
        with suppress(ValueError):  # another's value of that name
            self.energy |= {key: float(text) for key, text in found.items()}

    def summary(self) -> dict[str, object]:
        """Plain types for `summary.json`."""
        return {"interventions": self.count, "events": self.events, "stopped": self.stopped}
