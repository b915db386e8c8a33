# SPDX-License-Identifier: Apache-2.0
"""Bottom-hole assembly of a long string in balance on the low side, with its equations linearised there.

The balance is found for the whole string. Of the equations linearised there, the equations of the nodes below a cut are
kept. A damping that rises from the top of the assembly to the cut takes away the waves that run up the pipe, as if the
pipe had no end. So a mode of the assembly is damped by the waves that it radiates into the pipe, and modes of the pipe
are damped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.audit.energy import off_axis, rows_at
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.discretisation.joint import collars_of
from drill_twin.dynamics.discretisation.resolution import LONGEST_ELEMENT
from drill_twin.dynamics.rotordynamics.block_rows import BlockRows
from drill_twin.dynamics.rotordynamics.eigenvalues import Numbers, Pencil
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame
from drill_twin.dynamics.solver.linearisation import DAMPING, MASS
from drill_twin.physics.model import SPIN, Rod, rod_of, tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

SHORTEST, LONGEST_ASSEMBLY = 30.0, 300.0
"""Least and largest length of an assembly [m]."""
ABOVE, MOVED = 150.0, 250.0
"""Pipe above the assembly, and the same with the cut moved up [m]."""
PER_WAVE, PER_WAVE_ABOVE = 16, 8
"""Elements a bending wave at the fastest rotation, in the assembly and up to the cut: contact begins between nodes."""
LEAN = math.radians(1.0)
"""Inclination whose side load a vertical hole has here: no hole is exactly vertical [rad]."""


class Extent(NamedTuple):
    """Part of the string whose lateral motion is looked at, from the bit up [m]."""

    assembly: float
    cut: float

    @classmethod
    def of(cls, scene: Scene, above: float = ABOVE) -> Extent:
        """Assembly: all that is stiffer than the pipe at the top, up to the first that is not, and pipe above it."""
        tubes = tubes_of(scene)
        soft = min(tube_constants(tube)[1] for tube in tubes if tube.length == max(t.length for t in tubes))
        length = 0.0
        for tube in tubes:
            if tube_constants(tube)[1] <= soft:
                break
            length += tube.length
        length = min(max(length, SHORTEST), LONGEST_ASSEMBLY, scene.length)
        return cls(length, min(length + above, scene.length))


def graded_rod(scene: Scene, extent: Extent, fastest: float, finer: int = 1) -> Rod:
    """Mesh that is fine in the assembly, with elements of `LONGEST_ELEMENT` above the cut.

    Args:
        scene: The scene.
        extent: Assembly and cut.
        fastest: Fastest rotation [rad/s].
        finer: Factor on the number of elements up to the cut.
    """
    load, tubes, counts, begin = max(scene.rig.weight_on_bit.value, 0.0), [], [], 0.0
    for tube in tubes_of(scene):
        inner = [place - begin for place in extent if 0.5 < place - begin < tube.length - 0.5]
        for length in np.diff([0.0, *inner, tube.length]):
            _, bending, _, mass, _ = tube_constants(tube)
            wave = math.tau / math.sqrt((load + math.hypot(load, 2.0 * math.sqrt(bending * mass) * fastest))
                                        / (2.0 * bending))  # fmt: skip
            middle = begin + 0.5 * length
            size = wave / finer / (PER_WAVE if middle < extent.assembly else PER_WAVE_ABOVE)
            tubes.append(tube._replace(length=float(length)))
            counts.append(math.ceil(length / (size if middle < extent.cut else LONGEST_ELEMENT)))
            begin += float(length)
    return rod_of(tubes, counts)


@dataclass(frozen=True, eq=False)
class Assembly:
    """Lower part of a string in balance, with its equations linearised there; m unknowns of the nodes below the cut."""

    equations: EquationsOfMotion
    command: Command
    u: Array
    """Rows of the whole string in balance, shape (n + 1, 7)."""
    extent: Extent
    leans: bool = False
    """True in a vertical hole with the side load of `LEAN`."""

    @cached_property
    def collars(self) -> float:
        """Length of its collars [m], or its own where none are stiffer than its pipe."""
        return collars_of(self.equations.scene) or self.extent.assembly

    @cached_property
    def lying(self) -> Array:
        """1 for the nodes of elements that are on the wall in balance, else 0; shape (n + 1,)."""
        model = self.equations.model
        on = (np.linalg.norm(off_axis(model, self.u), axis=1) > model.wellbore.clearance).reshape(-1, 2).any(axis=1)
        return np.asarray(np.maximum(np.append(on, 0.0), np.append(0.0, on)), float)

    @cached_property
    def frame(self) -> HoleFrame:
        """Directions of the hole."""
        return HoleFrame.of(self.equations)

    @cached_property
    def rows(self) -> BlockRows:
        """Operations on the matrices of the m unknowns, of the nodes below the cut but for the spin, which is held."""
        equations, top = self.equations, self.equations.scene.length
        below = equations.model.rod.arc < (self.extent.cut - 1e-6 if self.extent.cut < top else math.inf)
        return BlockRows(equations.free & below[:, None] & (equations.columns != SPIN), equations.columns)

    @cached_property
    def part(self) -> Numbers:
        """Numbers of the m unknowns."""
        return np.flatnonzero(self.rows.free[self.equations.free])

    def linearised(self, rotation: float) -> Linearised:
        """Equations of the whole string in its balance, turning at a speed [rad/s].

        The spin is counted from a frame that turns about the string where the string moves sideways in an inclined
        hole. Here the spin is the material's: a spin that is held leaves the string without twist.
        """
        v = np.zeros_like(self.u)
        v[:, SPIN] = rotation
        system = self.equations.evaluate(Command(self.command.weight_on_bit, rotation), self.u, v, np.zeros_like(v))
        if self.equations.columns.size <= SPIN:
            return system
        slope = self.u[:, 3:6]
        size = np.linalg.norm(slope, axis=1)
        turn = np.cross([0.0, 0.0, 1.0], slope) / (size * (size + slope[:, 2]))[:, None]
        turn[0] = self.frame.bit @ turn[0]
        blocks = system.tangents.reshape(3, size.size, SPIN + 1, 3, SPIN + 1).copy()
        for k, near in enumerate((np.roll(turn, 1, axis=0), turn, np.roll(turn, -1, axis=0))):
            blocks[:, :, :, k, 3:6] += blocks[:, :, :, k, SPIN, None] * near[:, None, :]
        blocks[:, :, 3:6] += turn[:, :, None, None] * blocks[:, :, None, SPIN]
        return replace(system, tangents=blocks.reshape(system.tangents.shape))

    def entries(self, rotation: float, fastest: float) -> Array:
        """Mass, damping and stiffness of the m unknowns at the places of `rows`, shape (3, k).

        The damping absorbs motion above the assembly.
        """
        rows, (assembly, cut) = self.rows, self.extent
        found = np.array([rows.entries(tangent) for tangent in self.linearised(rotation).tangents])
        if cut < self.equations.scene.length:
            rise = np.clip((self.equations.model.rod.arc - assembly) / max(cut - assembly, 1e-9), 0.0, 1.0)
            root = math.sqrt(0.5 * fastest) * np.repeat(rise, rows.free.sum(axis=1))  # of the rate [1/s], by unknown
            found[DAMPING] += found[MASS] * root[rows.row] * root[rows.column]
        return found

    def pencil(self, rotation: float, fastest: float) -> Pencil:
        """The same as sparse matrices."""
        places = self.rows.row, self.rows.column
        return Pencil(*(csc_array((values, places)) for values in self.entries(rotation, fastest)))

    def on(self, other: Assembly, values: ComplexArray) -> ComplexArray:
        """Motion of the m unknowns on another mesh of the string, by the shape functions; without motion above."""
        whole, equations = np.zeros(self.equations.unknowns, complex), other.equations
        whole[self.part] = values
        rows = rows_at(self.equations.model.rod, self.frame.fixed(self.equations.rows(whole)), equations.model.rod.arc)
        return np.asarray(other.frame.fixed(rows, back=True)[:, equations.columns][other.rows.free], complex)


FindBalance = Callable[..., Array]
"""Function that gives the rows of a string in balance, of its equations, a command, and rows to begin with if any."""


def assembly_of(
    scene: Scene, command: Command, fastest: float, resting: FindBalance, *, above: float = ABOVE, finer: int = 1,
    near: Assembly | None = None,
) -> Assembly:  # fmt: skip
    """Find the balance of a long string on a mesh that suits its assembly.

    Args:
        scene: The scene.
        command: Weight on bit and rotation.
        fastest: Fastest rotation that is looked at [rad/s].
        resting: Balance of a string.
        above: Pipe above the assembly [m].
        finer: Factor on the number of elements.
        near: The same with another cut or mesh, from whose balance the search begins.

    Raises:
        RunError: There is no balance.
    """
    extent = Extent.of(scene, above)
    equations = EquationsOfMotion(scene, graded_rod(scene, extent, fastest, finer))
    gravity = getattr(equations.parameters, "gravity", None)
    upright = equations.model.inclination == 0.0 and equations.model.wellbore.axis is None
    leans = upright and gravity is not None
    if gravity is not None and leans:
        gravity.weight[:, 0] = math.sin(LEAN) * np.abs(gravity.weight[:, 2])
    begin = () if near is None else (rows_at(near.equations.model.rod, near.u, equations.model.rod.arc),)
    return Assembly(equations, command, resting(equations, command, *begin), extent, leans)
