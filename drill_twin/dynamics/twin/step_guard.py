# SPDX-License-Identifier: Apache-2.0
"""Step guard: plausibility check of each frame, rollback to the last good one, and step size control.

Before a frame the frame loop copies the state; after it, a compiled check evaluates the new one (`frame_kernel`). A
frame with a violation is rejected and repeated with half the step, up to `MAX_RETRIES` times; the step is doubled again
after every `GOOD_FRAMES_BEFORE_GROWTH` good frames.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import Array, Bytes
from drill_twin.dynamics.audit import state_check
from drill_twin.dynamics.solver.midpoint import SMALLEST_SHARE
from drill_twin.dynamics.twin.frame import EnergyBalance, Intervention
from drill_twin.dynamics.twin.frame_kernel import GOOD_FRAMES, SHARE, Limits
from drill_twin.dynamics.twin.state_bounds import DEPTH_MARGIN, StateBounds
from drill_twin.dynamics.twin.violation import NOT_RETRIED, Violation
from drill_twin.physics.effects.wall import Parameters as Wall
from drill_twin.physics.model.discrete_model import DiscreteModel

MAX_RETRIES = 6
"""Largest number of retries of a frame, each with half the step."""
SMALLEST_STEP = 2.0**-10
"""Smallest step of a frame over the nominal one [-]."""
HALVINGS_PER_STEP, HALVINGS_PER_FRAME = 200, 2000
"""Limit of step halvings in a frame: per nominal step, plus per frame. Beyond it the frame is rejected as too slow."""
GOOD_FRAMES_BEFORE_GROWTH = 10
"""Good frames after which a halved step is doubled."""
LARGEST_STRAIN = 0.5
"""Largest strain in size [-]; ten times that of the elastic law's validity."""
ENERGY_SHARE = 0.2
"""Largest change of the energy residual in a frame over the scale of the balance, with an audit [-]."""

FOLDING = 0.2
"""1 - t_z in a straight hole, a lean of 37 degrees, above which a string that has no solution is said to fold."""


def max_halvings(seconds: float, step: float) -> int:
    """Limit of step halvings in a frame of a length [s], with a nominal step [s]."""
    return HALVINGS_PER_FRAME + HALVINGS_PER_STEP * math.ceil(seconds / step)


class StepGuard:
    """Step guard of one twin.

    Attributes:
        bounds: Bounds of a plausible state.
        memory: Share of the nominal step and good frames since it was halved; part of a checkpoint.
        suspect: Node rows u and v of the last rejected state, shape (2, n + 1, 7).
        saved: Copy of the memory block at the start of the frame, made by the frame loop.
        extremes: Extremes of the last state checked (`drill_twin.dynamics.audit.state_check`).
        before: The same at the start of the frame.
    """

    def __init__(self, bounds: StateBounds, model: DiscreteModel, wall: Wall | None) -> None:
        self.set_bounds(bounds, wall)
        self.memory = np.array([1.0, 0.0])
        nodes = model.rod.arc.size
        self.suspect = np.zeros((2, nodes, 7))
        self._model = model
        self._block = self.saved = np.zeros(0, dtype=np.uint8)
        self.extremes = np.zeros(state_check.EXTREMES)
        self.before = np.zeros(state_check.EXTREMES)

    def set_bounds(self, bounds: StateBounds, wall: Wall | None) -> None:
        """Take the bounds of a plausible state, and the wall that they are of."""
        self.bounds, self._wall = bounds, wall

    @property
    def share(self) -> float:
        """Current step over the nominal one [-]."""
        return float(self.memory[SHARE])

    def attach(self, block: Bytes) -> None:
        """Attach the memory block of the twin, bytes of shape (size,)."""
        self._block, self.saved = block, block.copy()

    def limits(self, step: float) -> Limits:
        """Numbers for the compiled check of a frame; `step` is the nominal one [s]."""
        bounds, wall = self.bounds, self._wall
        return Limits(
            step, HALVINGS_PER_FRAME, HALVINGS_PER_STEP, GOOD_FRAMES_BEFORE_GROWTH, bounds.speed, bounds.tilt,
            np.inf if bounds.lateral else LARGEST_STRAIN, wall is not None, DEPTH_MARGIN,
            1.0 if wall is None else wall.stiffness, 1.0 if wall is None or wall.linear else 1.5, bounds.line_mass,
            bounds.flexibility, bounds.weight, bounds.line_load, bounds.curvature,
        )  # fmt: skip

    def exhausted(self, found: Violation, tries: int) -> bool:
        """True if a frame with this violation is not to be retried after so many tries."""
        return tries >= NOT_RETRIED.get(found.kind, MAX_RETRIES) or self.share <= SMALLEST_STEP

    def rollback(self, u: Array, v: Array) -> None:
        """Restore the saved state, and store the rejected one as `suspect`."""
        self.suspect[0], self.suspect[1] = u, v
        np.copyto(self._block, self.saved)

    def halve_step(self) -> None:
        """Halve the step."""
        self.memory[SHARE] *= 0.5
        self.memory[GOOD_FRAMES] = 0.0

    def count_good_frame(self) -> None:
        """Count a good frame, and double a halved step after `GOOD_FRAMES_BEFORE_GROWTH` of them."""
        if self.memory[SHARE] < 1.0:
            self.memory[GOOD_FRAMES] += 1.0
            if self.memory[GOOD_FRAMES] >= GOOD_FRAMES_BEFORE_GROWTH:
                self.memory[SHARE], self.memory[GOOD_FRAMES] = min(2.0 * self.memory[SHARE], 1.0), 0.0

    def check(self, u: Array, v: Array, depth: float, place: int, load: float, step: float) -> Violation | None:
        """Check a state; returns its violation, None if it is plausible.

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            depth: Largest penetration into the wall [m].
            place: Its Gauss point.
            load: Weight on bit, the larger of those at start and end of the frame [N].
            step: Time step [s].
        """
        seen, bounds = self.extremes, self.bounds
        state_check.check_state(self._model.rod, u, v, seen)
        if seen[state_check.BROKEN] >= 0.0:
            node = int(seen[state_check.BROKEN])
            return Violation("finite", node, f"the state of {self._at(node)} is no longer a number")
        if seen[state_check.SPEED] > bounds.speed:
            node = int(seen[state_check.SPEED_AT])
            return Violation(
                "speed", node,
                f"{self._at(node)} moved at {seen[state_check.SPEED]:.3g} m/s, faster than any string can "
                f"({bounds.speed:.4g} m/s)",
            )  # fmt: skip
        if seen[state_check.LEAN] > bounds.tilt:
            node = int(seen[state_check.LEAN_AT])
            angle = np.degrees(np.arccos(1.0 - seen[state_check.LEAN]))
            kind = "slope" if bounds.lateral else "fold"
            return Violation(
                kind, node,
                f"the string at {self._at(node)} leaned {angle:.0f} degrees from the upright"
                + ("" if bounds.lateral else ", folded back on itself"),
            )  # fmt: skip
        if not bounds.lateral and seen[state_check.STRAIN] > LARGEST_STRAIN:
            node = int(seen[state_check.STRAIN_AT])
            return Violation(
                "strain", node,
                f"the string at {self._at(node)} was stretched or squeezed by {100.0 * seen[state_check.STRAIN]:.3g} % "
                f"(expected at most {100.0 * LARGEST_STRAIN:g} %)",
            )  # fmt: skip
        if self._wall is not None and depth > 0.0:
            allowed = bounds.largest_depth(
                self._wall, max(float(self.before[state_check.SPEED]), float(seen[state_check.SPEED])), load, step
            )
            if depth > allowed:
                node = (place + 1) // 2
                return Violation(
                    "penetration", node,
                    f"the string at {self._at(node)} was {depth:.3g} m deep in the wall, where the contact law allows "
                    f"{allowed:.3g} m",
                )  # fmt: skip
        return None

    def diverged(self, u: Array, v: Array, step: float, halvings: int | None = None) -> Violation:
        """Violation of a frame in which Newton's method failed, or the step was halved too often.

        Args:
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
            step: Time step [s].
            halvings: Limit of halvings, if that was exceeded.
        """
        node = int(np.argmax(np.nan_to_num(np.linalg.norm(v[:, :3], axis=1), nan=np.inf)))
        why = (
            f"the equations had no solution, even at a step of {step * SMALLEST_SHARE:.2g} s"
            if halvings is None
            else f"a step of {step:.2g} s was cut more than {halvings} times within a frame"
        )
        return Violation(
            "newton", node,
            f"{why}; fastest was {self._at(node)}, {np.hypot(u[node, 0], u[node, 1]):.3g} m off the axis at "
            f"{np.linalg.norm(v[node, :3]):.3g} m/s{self._folding()}",
        )  # fmt: skip

    def too_slow(
        self, allowed: float, seconds: float, reached: float, steps: int, halvings: int, node: int
    ) -> Violation:
        """Violation of a frame that took more processor time than it may.

        Args:
            allowed: That time [s].
            seconds: Length of the frame [s].
            reached: Simulated time of it that was computed [s].
            steps: Steps taken.
            halvings: How often one was cut.
            node: Node at which Newton's method failed last.
        """
        cut = (
            f"{halvings} attempts of a step failed and were cut; Newton's method failed last at {self._at(node)}"
            if halvings
            else "none was cut"
        )
        return Violation(
            "slow" if halvings else "long", node,
            f"a frame of {seconds:.6g} s took more than {allowed:.6g} s of processor time (numerics.processor_time): "
            f"{steps} steps of {self._model.rod.length.size} elements led {reached:.3g} s into it, {cut}",
        )  # fmt: skip

    def _folding(self) -> str:
        """Lean of the last good state, where a string in a straight hole was about to fold."""
        if self.before[state_check.LEAN] <= FOLDING or self._model.wellbore.axis is not None:
            return ""
        angle = np.degrees(np.arccos(1.0 - self.before[state_check.LEAN]))
        place = self._at(int(self.before[state_check.LEAN_AT]))
        return f"; before, the string at {place} leaned {angle:.0f} degrees from the upright: it folds"

    def energy_drift(self, energy: EnergyBalance, grown: float) -> Violation | None:
        """Check the energy balance of a frame; returns its violation, if any.

        Args:
            energy: Energy balance at its end.
            grown: Change of the residual in the frame [J].
        """
        if abs(grown) <= ENERGY_SHARE * energy.scale:
            return None
        node = int(self.extremes[state_check.SPEED_AT])
        return Violation(
            "energy", node,
            f"{abs(grown):.3g} J were {'gained' if grown > 0.0 else 'lost'} that nothing accounts for, of "
            f"{energy.scale:.3g} J on the move; fastest was {self._at(node)}{self._folding()}",
        )  # fmt: skip

    def _at(self, node: int) -> str:
        """Describe a node for messages."""
        return f"node {node}, {self._model.rod.arc[node]:.4g} m from the bit"

    def intervention(self, time: float, found: Violation, tries: int, step: float) -> Intervention:
        """Make the record of a repeated frame."""
        return Intervention(
            time, found.kind, found.node, float(self._model.rod.arc[found.node]),
            f"at {time:.6g} s {found.text}; taken back and done again with a step of {step:.3g} s",
            tries, step,
        )  # fmt: skip
