# SPDX-License-Identifier: Apache-2.0
"""The energy balance of a run, from the books that the kernel keeps (`numerics: {audit: energy}`).

Work done on the string = change of what it stores + heat + residual. The midpoint rule closes this to round-off for
quadratic energies; for others (large deflection, the wall) the residual is second order in the step, and it holds
whatever Newton's method left undone. A force that acts without being booked shows in it at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.effects import BLOCKS
from drill_twin.effects.wall import Parameters as Wall
from drill_twin.frame import EnergyBalance
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.solve.audit import (
    ACCOUNTS,
    BEGUN,
    EFFECTS,
    LARGEST,
    LOST,
    NEWTON,
    NOW,
    RESIDUE,
    START,
    STORED,
    WORK,
    Ledger,
)
from drill_twin.solve.energy import energy, lateral_energy, wall_energy

HEAT = frozenset(key for key, block in BLOCKS.items() if block.work == "heat")
SLOWEST = 1e-3
"""Speed below which no motion is worth an audit [m/s]: the energy of the whole string at it is the least scale."""


class Books:
    """Reads the ledger of one twin."""

    def __init__(self, ledger: Ledger, effects: Sequence[str], site: Site, wall: Wall | None, *, lateral: bool) -> None:
        self._books, self._site, self._wall, self._lateral = ledger.books, site, wall, lateral
        self._effects = tuple(effects)
        rod = site.rod
        self._least = 0.5 * float(np.sum(rod.line_mass * rod.length)) * SLOWEST**2

    def begin(self, u: Array, v: Array) -> None:
        """Remember what is stored at the start of the run; once."""
        if self._books[NOW, BEGUN] == 0.0:
            self._books[NOW, BEGUN] = 1.0
            self._books[START, :STORED] = self._stored(u, v)

    def _stored(self, u: Array, v: Array) -> Array:
        rod = self._site.rod
        held = wall_energy(self._site, self._wall, u) if self._wall is not None else 0.0
        return np.array([*(lateral_energy if self._lateral else energy)(rod, u, v), held])

    def balance(self, u: Array, v: Array) -> tuple[EnergyBalance, float]:
        """The balance now, and by how much the residual has grown since it was last asked for [J].

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
        """
        books = self._books
        now = self._stored(u, v)
        work = dict(zip((*ACCOUNTS, *self._effects), books[WORK].tolist(), strict=False))
        lost = {name: -work[name] for name in self._effects if name in HEAT}
        if "wall" in self._effects:
            lost["wall"] = float(books[LOST, EFFECTS + self._effects.index("wall")])
        newton = work.pop(ACCOUNTS[NEWTON])
        kinetic, bending, stretch, torsion, wall = (now - books[START, :STORED]).tolist()
        given = sum(done for name, done in work.items() if name != "wall")
        residual = kinetic + bending + stretch + torsion + wall + lost.get("wall", 0.0) - given
        moving = float(now[0]) + abs(bending + stretch + torsion + wall) + sum(lost.values())
        books[NOW, LARGEST] = max(books[NOW, LARGEST], moving)
        grown = residual - float(books[NOW, RESIDUE])
        books[NOW, RESIDUE] = residual
        stored = {
            "kinetic": float(now[0]), "bending": float(now[1]), "stretch": float(now[2]), "torsion": float(now[3]),
            "gravity": -work.get("gravity", 0.0), "wall": float(now[4]),
        }  # fmt: skip
        scale = max(float(books[NOW, LARGEST]), self._least)
        return EnergyBalance(stored, work, lost, residual, scale, newton), grown
