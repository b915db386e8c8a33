# SPDX-License-Identifier: Apache-2.0
"""The guard: what no state of a string can be, and a way back to the last good frame.

Before each frame the guard keeps the twin's memory in arrays of its own; after it, a compiled pass looks at the state.
What cannot be meant is taken back and done again with half the step, up to `TRIES` times; the step grows back by
doubling, each time after `CALM` good frames. The bounds are wide on purpose: they tell a motion that has broken down,
not one that is inaccurate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drill_twin.effects.wall import Parameters as Wall
from drill_twin.frame import EnergyBalance, Intervention
from drill_twin.rod.site import Site
from drill_twin.rod.types import Array
from drill_twin.scene import Scene
from drill_twin.solve import vitals
from drill_twin.solve.hang import axial_weight
from drill_twin.solve.resolution import impact_depth
from drill_twin.solve.setting import sections_of

TRIES = 6
"""How often a frame is done again, each time with half the step."""
SMALLEST = 2.0**-10
"""Of the nominal step, below which no frame is tried."""
CALM = 10
"""Good frames after which a halved step doubles."""
LARGEST_STRAIN = 0.5
"""Largest strain in size; the elastic law is not meant for a tenth of it."""
FOLDED, ACROSS = 1.99, 0.8
"""Most that 1 - t_z may be: in space 172 degrees, as a string folded back has no twist; and in the
lateral form, which is for small slopes."""
NO_MATTER_OF_STEP = {"fold", "slope"}
"""What no smaller step mends: one try has to do."""
LEAST_SPEED = 1000.0
"""Speed that no string is refused [m/s]."""
DEEPER = 10.0
"""Times the depth that the contact law gives for the impact and the load at hand."""
ENERGY_SHARE = 0.2
"""Share of the energy on the move that a frame may lose track of, where the scene asks for the audit."""

SHARE, GOOD = 0, 1  # places in Guard.memory: share of the nominal step, good frames since it was halved

REMEDIES = {
    "finite": "look at the parameters of the effect that is named",
    "newton": "try a lower load (the string may have folded), a smaller numerics.step, more elements, or a softer wall",
    "speed": "try a smaller numerics.step, or look at the parameters of the effect that is named",
    "strain": "try a lower load; no drillstring is meant to be stretched or squeezed so far",
    "fold": "try a lower load, or list `wall`, which keeps the string from folding",
    "slope": "list `stretch` and `torsion` (the motion across the hole alone is meant for small slopes), or `wall`",
    "penetration": "try a smaller numerics.step, a stiffer wall, or a lower load",
    "energy": "try a smaller numerics.step or more elements",
}


@dataclass(frozen=True)
class Violation:
    """What a state cannot be."""

    kind: str
    """finite, newton, speed, strain, fold, slope, penetration or energy."""
    node: int
    """Where it is worst."""
    text: str
    """What was found there and what was expected, in words."""


@dataclass(frozen=True)
class Bounds:
    """What a state can be."""

    speed: float
    """Sound in the string, or `LEAST_SPEED` where it is softer than what strings are made of [m/s]."""
    lean: float
    """Most that 1 - t_z may be."""
    lateral: bool
    """Whether the string only moves across the hole."""
    line_mass: float
    """Largest mass per length, mud included [kg/m]."""
    flexibility: float
    """Largest clearance over 4 EI [1/(N m)]: with the load squared, how a helix presses on the wall [N/m]."""
    weight: float
    """Weight of the string [N]."""
    line_weight: float
    """Largest weight per length [N/m]."""
    curvature: float
    """Largest curvature of the hole [1/m]."""

    def depth(self, wall: Wall, speed: float, load: float, step: float) -> float:
        """Deepest that the string can be in the wall [m].

        What the law gives for the hardest impact, K d^(p+1) / (p+1) = m v^2 / 2 per length, and for the load, the
        helix's F^2 r / (4 EI) (Lubinski, Althouse and Logan 1962) with weight and curvature, `DEEPER` times both; and
        as far as the string goes in a step, since a long step meets the wall only at its ends.

        Args:
            wall: Law of the wall.
            speed: Fastest place of the string [m/s].
            load: Weight on bit [N].
            step: Time step [s].
        """
        power = 1.0 if wall.linear else 1.5
        impact = impact_depth(wall, self.line_mass, speed)
        axial = abs(load) + self.weight
        pressed = ((axial**2 * self.flexibility + axial * self.curvature + self.line_weight) / wall.stiffness) ** (
            1.0 / power
        )
        return float(DEEPER * (impact + pressed) + speed * step)


def bounds_of(scene: Scene, site: Site, *, lateral: bool) -> Bounds:
    """The bounds of a scene."""
    rod, bore = site.rod, site.bore
    weight = np.abs(axial_weight(scene, site))
    gravity = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    mud = site.fluid_density * 4.0 * np.pi * site.contact_radius.max() ** 2
    clearance = bore.clearance.reshape(-1, 2).max(axis=1)
    return Bounds(
        speed=max(LEAST_SPEED, *(float(np.sqrt(tube.youngs_modulus / tube.density)) for tube in sections_of(scene))),
        lean=ACROSS if lateral else FOLDED,
        lateral=lateral,
        line_mass=float(rod.line_mass.max() + mud),
        flexibility=float(np.max(clearance / (4.0 * rod.bending))),
        weight=float(weight.sum()),
        line_weight=float(gravity * rod.line_mass.max()),
        curvature=0.0 if bore.axis is None else float(bore.axis.curvature.max()),
    )


class Guard:
    """Looks after one twin.

    Attributes:
        memory: Share of the nominal step and good frames since; part of a checkpoint.
        suspect: Node rows u and v of the last state that was taken back, shape (2, n + 1, 7).
    """

    def __init__(self, bounds: Bounds, site: Site, wall: Wall | None) -> None:
        self.bounds = bounds
        self.memory = np.array([1.0, 0.0])
        nodes = site.rod.arc.size
        self.suspect = np.zeros((2, nodes, 7))
        self._site, self._wall = site, wall
        self._arrays: Sequence[Array] = ()
        self._kept: list[Array] = []
        self._vitals = np.zeros(vitals.VITALS)
        self._speed = 0.0

    @property
    def share(self) -> float:
        """Share of the nominal step that is taken at present."""
        return float(self.memory[SHARE])

    def watch(self, arrays: Sequence[Array]) -> None:
        """Say once which arrays are the twin's memory."""
        self._arrays = arrays
        self._kept = [array.copy() for array in arrays]

    def keep(self, u: Array, v: Array) -> None:
        """Keep the twin's memory as it is now, the last good one; node rows u and v are part of it."""
        for kept, array in zip(self._kept, self._arrays, strict=True):
            np.copyto(kept, array)
        vitals.look(self._site.rod, u, v, self._vitals)
        self._speed = float(self._vitals[vitals.SPEED])

    def take_back(self, u: Array, v: Array) -> None:
        """Go back to what was kept, and remember the state that was not good."""
        self.suspect[0], self.suspect[1] = u, v
        for kept, array in zip(self._kept, self._arrays, strict=True):
            np.copyto(array, kept)

    def halve(self) -> None:
        """Take half the step from now on."""
        self.memory[SHARE] *= 0.5
        self.memory[GOOD] = 0.0

    def grow(self) -> None:
        """A good frame has passed: let the step grow back."""
        if self.memory[SHARE] < 1.0:
            self.memory[GOOD] += 1.0
            if self.memory[GOOD] >= CALM:
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
        seen, bounds = self._vitals, self.bounds
        vitals.look(self._site.rod, u, v, seen)
        if seen[vitals.BROKEN] >= 0.0:
            node = int(seen[vitals.BROKEN])
            return Violation("finite", node, f"the state of {self.at(node)} is no longer a number")
        if seen[vitals.SPEED] > bounds.speed:
            node = int(seen[vitals.SPEED_AT])
            return Violation(
                "speed", node,
                f"{self.at(node)} moved at {seen[vitals.SPEED]:.3g} m/s, faster than any string can "
                f"({bounds.speed:.4g} m/s)",
            )  # fmt: skip
        if seen[vitals.LEAN] > bounds.lean:
            node = int(seen[vitals.LEAN_AT])
            angle = np.degrees(np.arccos(1.0 - seen[vitals.LEAN]))
            kind = "slope" if bounds.lateral else "fold"
            return Violation(
                kind, node,
                f"the string at {self.at(node)} leaned {angle:.0f} degrees from the upright"
                + ("" if bounds.lateral else ", folded back on itself"),
            )  # fmt: skip
        if not bounds.lateral and seen[vitals.STRAIN] > LARGEST_STRAIN:
            node = int(seen[vitals.STRAIN_AT])
            return Violation(
                "strain", node,
                f"the string at {self.at(node)} was stretched or squeezed by {100.0 * seen[vitals.STRAIN]:.3g} %, "
                f"where at most {100.0 * LARGEST_STRAIN:g} % can be meant",
            )  # fmt: skip
        if self._wall is not None and depth > 0.0:
            allowed = bounds.depth(self._wall, max(self._speed, float(seen[vitals.SPEED])), load, step)
            if depth > allowed:
                node = (place + 1) // 2
                return Violation(
                    "penetration", node,
                    f"the string at {self.at(node)} was {depth:.3g} m deep in the wall, where the contact law allows "
                    f"{allowed:.3g} m",
                )  # fmt: skip
        return None

    def unaccounted(self, energy: EnergyBalance, grown: float) -> Violation | None:
        """Whether a frame has lost track of too much energy.

        Args:
            energy: The balance after it.
            grown: By how much its residual has grown in the frame [J].
        """
        if abs(grown) <= ENERGY_SHARE * energy.scale:
            return None
        node = int(self._vitals[vitals.SPEED_AT])
        return Violation(
            "energy", node,
            f"{abs(grown):.3g} J were {'gained' if grown > 0.0 else 'lost'} that nothing accounts for, of "
            f"{energy.scale:.3g} J on the move; fastest was {self.at(node)}",
        )  # fmt: skip

    def at(self, node: int) -> str:
        """A node in words."""
        return f"node {node}, {self._site.rod.arc[node]:.4g} m from the bit"

    def intervention(self, time: float, found: Violation, tries: int, step: float) -> Intervention:
        """The record of a frame that was done again."""
        return Intervention(
            time, found.kind, found.node, float(self._site.rod.arc[found.node]),
            f"at {time:.6g} s {found.text}; taken back and done again with a step of {step:.3g} s",
            tries, step,
        )  # fmt: skip
