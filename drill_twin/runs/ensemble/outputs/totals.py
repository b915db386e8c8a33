# SPDX-License-Identifier: Apache-2.0
"""Sums that the twin itself keeps over a run: fatigue and energy."""

from __future__ import annotations

from collections.abc import Mapping

from drill_twin.core.errors import ArgumentError
from drill_twin.physics.model.section_stress import CYCLES, DAMAGE, LARGEST_STRESS
from drill_twin.runs.ensemble.outputs.collector import Collector, Variable


class Fatigue(Collector):
    """Stress and damage of the sections of scenes with the effect `fatigue`."""

    def close(self) -> Mapping[str, Variable]:
        """Largest stress, cycles and damage of the whole run."""
        found = self.twin.dynamics.stress
        if found is None:
            raise ArgumentError("outputs: expected a scene with effects.fatigue for `fatigue`, found none")
        columns = (("largest_stress", LARGEST_STRESS, "Pa"), ("stress_cycles", CYCLES, "1"), ("damage", DAMAGE, "1"))
        return {name: Variable(found[:, column].copy(), ("section",), unit) for name, column, unit in columns}


class Energy(Collector):
    """Energy balance at the end, of scenes with `numerics.audit: energy`."""

    def close(self) -> Mapping[str, Variable]:
        """Dissipation by effect, work, and the residual."""
        found = self.twin.energy()
        if found is None:
            raise ArgumentError("outputs: expected a scene with numerics.audit: energy for `energy`, found none")
        parts = {f"dissipated_{name}": value for name, value in found.dissipated.items()}
        parts |= {f"work_{name}": value for name, value in found.work.items()}
        parts |= {f"stored_{name}": value for name, value in found.stored.items()}
        return {
            **{f"energy_{name}": Variable(value, (), "J") for name, value in parts.items()},
            "energy_residual": Variable(found.share, (), "1"),
        }
