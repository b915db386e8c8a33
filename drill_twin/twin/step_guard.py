# SPDX-License-Identifier: Apache-2.0
"""The guard: what no state of a string can be, and a way back to the last good frame.

Before each frame the guard keeps a copy of the twin's memory; after it, a compiled pass looks at the state.
What cannot be meant is taken back and done again with half the step, up to `MAX_RETRIES` times; the step grows back by
doubling, each time after `GOOD_FRAMES_BEFORE_GROWTH` good frames.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.audit import state_check
from drill_twin.base.arrays import Array, Bytes
from drill_twin.effects.wall import Parameters as Wall
from drill_twin.model.discrete_model import DiscreteModel
from drill_twin.solver.midpoint import SMALLEST_SHARE
from drill_twin.twin.frame import EnergyBalance, Intervention
from drill_twin.twin.state_bounds import Bounds
from drill_twin.twin.violation import NO_MATTER_OF_STEP, Violation

MAX_RETRIES = 6
"""How often a frame is done again, each time with half the step."""
SMALLEST = 2.0**-10
"""Of the nominal step, below which no frame is tried."""
HALVINGS_PER_STEP, HALVINGS_PER_FRAME = 200, 2000
"""How often the step may be cut within a frame: by nominal steps, and besides. Beyond it nobody would wait."""
GOOD_FRAMES_BEFORE_GROWTH = 10
"""Good frames after which a halved step doubles."""
LARGEST_STRAIN = 0.5
"""Largest strain in size; the elastic law is not meant for a tenth of it."""
ENERGY_SHARE = 0.2
"""Share of the energy on the move that a frame may lose track of, where the scene asks for the audit."""

SHARE, GOOD = 0, 1  # places in StepGuard.memory: share of the nominal step, good frames since it was halved


def max_halvings(seconds: float, step: float) -> int:
    """How often the step may be cut within a frame of a length [s]; a smaller one than the nominal [s] needs fewer."""
    return HALVINGS_PER_FRAME + HALVINGS_PER_STEP * math.ceil(seconds / step)


class StepGuard:
    """Looks after one twin.

    Attributes:
        memory: Share of the nominal step and good frames since; part of a checkpoint.
        suspect: Node rows u and v of the last state that was taken back, shape (2, n + 1, 7).
    """

    def __init__(self, bounds: Bounds, model: DiscreteModel, wall: Wall | None) -> None:
        self.bounds = bounds
        self.memory = np.array([1.0, 0.0])
        nodes = model.rod.arc.size
        self.suspect = np.zeros((2, nodes, 7))
        self._model, self._wall = model, wall
        self._block = self._kept = np.zeros(0, dtype=np.uint8)
        self._extremes = np.zeros(state_check.EXTREMES)
        self._speed = 0.0

    @property
    def share(self) -> float:
        """Share of the nominal step that is taken at present."""
        return float(self.memory[SHARE])

    def watch(self, block: Bytes) -> None:
        """Say once where the twin's memory is, bytes of shape (size,)."""
        self._block, self._kept = block, block.copy()

    def keep(self, u: Array, v: Array) -> None:
        """Keep the twin's memory as it is now, the last good one; node rows u and v are part of it."""
        np.copyto(self._kept, self._block)
        state_check.check_state(self._model.rod, u, v, self._extremes)
        self._speed = float(self._extremes[state_check.SPEED])

    def gives_up(self, found: Violation, tries: int) -> bool:
        """Whether a frame is not to be tried again after so many tries."""
        return tries >= (1 if found.kind in NO_MATTER_OF_STEP else MAX_RETRIES) or self.share <= SMALLEST

    def rollback(self, u: Array, v: Array) -> None:
        """Go back to what was kept, and remember the state that was not good."""
        self.suspect[0], self.suspect[1] = u, v
        np.copyto(self._block, self._kept)

    def halve(self) -> None:
        """Take half the step from now on."""
        self.memory[SHARE] *= 0.5
        self.memory[GOOD] = 0.0

    def grow(self) -> None:
        """A good frame has passed: let the step grow back."""
        if self.memory[SHARE] < 1.0:
            self.memory[GOOD] += 1.0
            if self.memory[GOOD] >= GOOD_FRAMES_BEFORE_GROWTH:
                self.memory[SHARE], self.memory[GOOD] = min(2.0 * self.memory[SHARE], 1.0), 0.0

    def find(self, u: Array, v: Array, depth: float, place: int, load: float, step: float) -> Violation | None:
        """What the state cannot be, None if all is well.

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            depth: Deepest place beyond the wall [m].
            place: Its Gauss point.
            load: Weight on bit, the larger of those at start and end of the frame [N].
            step: Time step [s].
        """
        seen, bounds = self._extremes, self.bounds
        state_check.check_state(self._model.rod, u, v, seen)
        if seen[state_check.BROKEN] >= 0.0:
            node = int(seen[state_check.BROKEN])
            return Violation("finite", node, f"the state of {self.at(node)} is no longer a number")
        if seen[state_check.SPEED] > bounds.speed:
            node = int(seen[state_check.SPEED_AT])
            return Violation(
                "speed", node,
                f"{self.at(node)} moved at {seen[state_check.SPEED]:.3g} m/s, faster than any string can "
                f"({bounds.speed:.4g} m/s)",
            )  # fmt: skip
        if seen[state_check.LEAN] > bounds.lean:
            node = int(seen[state_check.LEAN_AT])
            angle = np.degrees(np.arccos(1.0 - seen[state_check.LEAN]))
            kind = "slope" if bounds.lateral else "fold"
            return Violation(
                kind, node,
                f"the string at {self.at(node)} leaned {angle:.0f} degrees from the upright"
                + ("" if bounds.lateral else ", folded back on itself"),
            )  # fmt: skip
        if not bounds.lateral and seen[state_check.STRAIN] > LARGEST_STRAIN:
            node = int(seen[state_check.STRAIN_AT])
            return Violation(
                "strain", node,
                f"the string at {self.at(node)} was stretched or squeezed by {100.0 * seen[state_check.STRAIN]:.3g} %, "
                f"where at most {100.0 * LARGEST_STRAIN:g} % can be meant",
            )  # fmt: skip
        if self._wall is not None and depth > 0.0:
            allowed = bounds.depth(self._wall, max(self._speed, float(seen[state_check.SPEED])), load, step)
            if depth > allowed:
                node = (place + 1) // 2
                return Violation(
                    "penetration", node,
                    f"the string at {self.at(node)} was {depth:.3g} m deep in the wall, where the contact law allows "
                    f"{allowed:.3g} m",
                )  # fmt: skip
        return None

    def diverged(self, u: Array, v: Array, step: float, halvings: int | None = None) -> Violation:
        """What it means that the equations had no solution, or one only with steps that nobody waits for.

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            step: Time step that was tried [s].
            halvings: How often it was cut, if that was too often.
        """
        node = int(np.argmax(np.nan_to_num(np.linalg.norm(v[:, :3], axis=1), nan=np.inf)))
        why = (
            f"the equations had no solution, even at a step of {step * SMALLEST_SHARE:.2g} s"
            if halvings is None
            else f"a step of {step:.2g} s was cut more than {halvings} times within a frame"
        )
        return Violation(
            "newton", node,
            f"{why}; fastest was {self.at(node)}, {np.hypot(u[node, 0], u[node, 1]):.3g} m off the axis at "
            f"{np.linalg.norm(v[node, :3]):.3g} m/s",
        )  # fmt: skip

    def energy_drift(self, energy: EnergyBalance, grown: float) -> Violation | None:
        """Whether a frame has lost track of too much energy.

        Args:
            energy: The balance after it.
            grown: By how much its residual has grown in the frame [J].
        """
        if abs(grown) <= ENERGY_SHARE * energy.scale:
            return None
        node = int(self._extremes[state_check.SPEED_AT])
        return Violation(
            "energy", node,
            f"{abs(grown):.3g} J were {'gained' if grown > 0.0 else 'lost'} that nothing accounts for, of "
            f"{energy.scale:.3g} J on the move; fastest was {self.at(node)}",
        )  # fmt: skip

    def at(self, node: int) -> str:
        """A node in words."""
        return f"node {node}, {self._model.rod.arc[node]:.4g} m from the bit"

    def intervention(self, time: float, found: Violation, tries: int, step: float) -> Intervention:
        """The record of a frame that was done again."""
        return Intervention(
            time, found.kind, found.node, float(self._model.rod.arc[found.node]),
            f"at {time:.6g} s {found.text}; taken back and done again with a step of {step:.3g} s",
            tries, step,
        )  # fmt: skip
