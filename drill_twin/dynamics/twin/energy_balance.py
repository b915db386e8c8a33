# SPDX-License-Identifier: Apache-2.0
"""Energy balance of a run, from the ledger of the kernel (`numerics: {audit: energy}`).

Work done on the string = change of the stored energy + dissipation + residual. The midpoint rule closes the balance to
round-off for quadratic energies; for others (large deflection, the wall) the residual is second order in the step, plus
the error of Newton's method. Any force missing in the ledger appears in the residual.
"""

from collections.abc import Callable, Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.audit.energy import Energy, wall_energy
from drill_twin.dynamics.audit.energy_ledger import (
    ACCOUNTS,
    BEGUN,
    FIRST_EFFECT,
    LARGEST,
    LOST,
    NEWTON,
    NOW,
    RESIDUE,
    START,
    STORED,
    WORK,
    EnergyLedger,
)
from drill_twin.dynamics.twin.frame import EnergyBalance
from drill_twin.physics.effects import EFFECTS
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model import DiscreteModel

HEAT = frozenset(key for key, block in EFFECTS.items() if block.energy_class == "heat")
SLOWEST = 1e-3
"""Speed of the string whose kinetic energy is the least scale of the balance [m/s]."""


class EnergyAudit:
    """Energy balance of one twin."""

    def __init__(
        self,
        ledger: EnergyLedger,
        effects: Sequence[str],
        model: DiscreteModel,
        wall: Wall | None,
        energy_of: Callable[[Array, Array], Energy],
    ) -> None:
        """`energy_of` is the energy of node rows and their velocities in the formulation of the twin."""
        self._entries, self._model, self._wall, self._energy_of = ledger.entries, model, wall, energy_of
        self._effects = tuple(effects)
        rod = model.rod
        self._least = 0.5 * float(np.sum(rod.line_mass * rod.length)) * SLOWEST**2

    def begin(self, u: Array, v: Array) -> None:
        """Store the energies at the start of the run; no-op after the first call."""
        if self._entries[NOW, BEGUN] == 0.0:
            self._entries[NOW, BEGUN] = 1.0
            self._entries[START, :STORED] = self._stored(u, v)

    def _stored(self, u: Array, v: Array) -> Array:
        held = wall_energy(self._model, self._wall, u) if self._wall is not None else 0.0
        return np.array([*self._energy_of(u, v), held])

    def balance(self, u: Array, v: Array) -> tuple[EnergyBalance, float]:
        """Energy balance, and the change of its residual since the last call [J].

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
        """
        entries = self._entries
        now = self._stored(u, v)
        work = dict(zip((*ACCOUNTS, *self._effects), entries[WORK].tolist(), strict=False))
        lost = {name: -work[name] for name in self._effects if name in HEAT}
        if "wall" in self._effects:
            lost["wall"] = float(entries[LOST, FIRST_EFFECT + self._effects.index("wall")])
        newton = work.pop(ACCOUNTS[NEWTON])
        kinetic, bending, stretch, torsion, wall = (now - entries[START, :STORED]).tolist()
        given = sum(done for name, done in work.items() if name != "wall")
        residual = kinetic + bending + stretch + torsion + wall + lost.get("wall", 0.0) - given
        moving = float(now[0]) + abs(bending + stretch + torsion + wall) + sum(lost.values())
        entries[NOW, LARGEST] = max(entries[NOW, LARGEST], moving)
        grown = residual - float(entries[NOW, RESIDUE])
        entries[NOW, RESIDUE] = residual
        stored = {
            "kinetic": float(now[0]), "bending": float(now[1]), "stretch": float(now[2]), "torsion": float(now[3]),
            "gravity": -work.get("gravity", 0.0), "wall": float(now[4]),
        }  # fmt: skip
        scale = max(float(entries[NOW, LARGEST]), self._least)
        return EnergyBalance(stored, work, lost, residual, scale, newton), grown
