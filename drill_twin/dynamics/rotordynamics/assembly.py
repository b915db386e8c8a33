# SPDX-License-Identifier: Apache-2.0
"""Lateral modes of the bottom-hole assembly of a long string about its balance on the low side.

The balance is that of the whole string. Of its equations there, those of the nodes below a cut are kept; a damping that
rises from the top of the assembly to the cut takes away the waves that run up the pipe, as if it had no end. So a mode
of the assembly has the damping of what it radiates into the pipe, and modes of the pipe are damped. A mode that
is one of the assembly stays where it is when the cut is moved; one that moves is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.discretisation.resolution import LONGEST
from drill_twin.dynamics.rotordynamics.eigenvalues import Numbers, Pencil, delayed_modes, modes_near
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.dynamics.rotordynamics.modes import LATERAL, Balance, Mode, ModeTable, classed, listed
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame
from drill_twin.dynamics.solver.linearisation import DAMPING, MASS, STIFFNESS
from drill_twin.physics.model.mesh import SPIN, Rod, rod_of, tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

SHORTEST, LONGEST_ASSEMBLY = 30.0, 300.0
"""Least and largest length of an assembly [m]: less where the string is of nothing but pipe, more is far from the bit."""
ABOVE, MOVED = 150.0, 250.0
"""Pipe above the assembly, and the same with the cut moved up [m]."""
PER_WAVE, PER_WAVE_ABOVE = 16, 8
"""Elements a bending wave at the fastest rotation, in the assembly and up to the cut: contact begins between nodes."""
LEAN = math.radians(1.0)
"""Inclination whose side load a vertical hole has here: no hole is exactly vertical [rad]."""
NEAREST = 60
"""Eigenvalues computed around a point of the imaginary axis."""
STAYS = 0.01
"""Change of an eigenvalue, over its size, up to which a mode does not move with the cut."""
LIGHT = 0.15
"""Damping ratio below which a mode has a critical speed: above it, it is hardly felt."""


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
    """Mesh that is fine in the assembly, with elements of `LONGEST` above the cut.

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
            counts.append(math.ceil(length / (size if middle < extent.cut else LONGEST)))
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

    @cached_property
    def frame(self) -> HoleFrame:
        """Directions of the hole."""
        return HoleFrame.of(self.equations)

    @cached_property
    def part(self) -> Numbers:
        """Numbers of the m unknowns: those of the nodes below the cut but for the spin, which the drive holds."""
        equations, top = self.equations, self.equations.scene.length
        below = equations.model.rod.arc < (self.extent.cut - 1e-6 if self.extent.cut < top else math.inf)
        return np.flatnonzero((below[:, None] & (equations.columns != SPIN))[equations.free])

    def absorption(self, fastest: float) -> Array:
        """Rate at which motion above the assembly is absorbed [1/s], by unknown, shape (m,)."""
        arc, (assembly, cut) = self.equations.model.rod.arc, self.extent
        rise = np.clip((arc - assembly) / max(cut - assembly, 1e-9), 0.0, 1.0)
        if cut >= self.equations.scene.length:
            rise[:] = 0.0
        rate = np.broadcast_to((0.5 * fastest * rise**2)[:, None], self.equations.free.shape)
        return np.asarray(rate[self.equations.free][self.part])

    def linearised(self, rotation: float) -> Linearised:
        """Equations of the whole string in its balance, turning at a speed [rad/s]."""
        v = np.zeros_like(self.u)
        v[:, SPIN] = rotation
        return self.equations.evaluate(Command(self.command.weight_on_bit, rotation), self.u, v, np.zeros_like(v))

    def pencil(self, rotation: float, fastest: float) -> Pencil:
        """Mass, damping and stiffness of the unknowns below the cut, sparse."""
        system = self.linearised(rotation)
        mass, damping, stiffness = (
            system.rows.sparse(system.tangents[which])[self.part][:, self.part]
            for which in (MASS, DAMPING, STIFFNESS)
        )
        root = np.sqrt(self.absorption(fastest))
        return Pencil(mass, damping + mass * root[:, None] * root[None, :], stiffness)


Resting = Callable[[EquationsOfMotion, Command], Array]
"""Rows of a string in balance under a command."""


def assembly_of(
    scene: Scene, command: Command, fastest: float, resting: Resting, *, above: float = ABOVE, finer: int = 1
) -> Assembly:
    """Find the balance of a long string on a mesh that suits its assembly.

    Args:
        scene: The scene.
        command: Weight on bit and rotation.
        fastest: Fastest rotation that is looked at [rad/s].
        resting: Balance of a string.
        above: Pipe above the assembly [m].
        finer: Factor on the number of elements.

    Raises:
        RunError: There is no balance.
    """
    extent = Extent.of(scene, above)
    equations = EquationsOfMotion(scene, graded_rod(scene, extent, fastest, finer))
    gravity = getattr(equations.parameters, "gravity", None)
    if equations.model.inclination == 0.0 and equations.model.wellbore.axis is None and gravity is not None:
        gravity.weight[:, 0] = math.sin(LEAN) * np.abs(gravity.weight[:, 2])
    return Assembly(equations, command, resting(equations, command), extent)


def lateral_modes(assembly: Assembly, fastest: float) -> list[Mode]:
    """Lateral modes up to the frequency of the fastest rotation [rad/s] whose motion is mostly in the assembly."""
    pencil = assembly.pencil(assembly.command.rotation, fastest)
    spectrum = _along_axis(pencil, 0.0, fastest)
    found: list[Mode] = []
    inside = assembly.equations.model.rod.arc <= assembly.extent.assembly
    for value, vector in spectrum:
        if any(abs(value - mode.eigenvalue) < 1e-6 * abs(value) for mode in found):
            continue
        if 0.0 < value.imag <= fastest and -value.real < LIGHT * abs(value):
            mode = classed(assembly.equations, assembly.frame, assembly.part, pencil.mass, complex(value), vector)
            if mode.kind == LATERAL and inside[int(np.argmax(np.abs(mode.shape)))]:
                found.append(mode)
    return sorted(found, key=lambda mode: mode.eigenvalue.imag)


def _along_axis(pencil: Pencil, low: float, high: float) -> list[tuple[complex, ComplexArray]]:
    """Eigenvalues near a stretch of the imaginary axis [rad/s], without gaps, and their shapes; some of them twice."""
    middle = 0.5j * (low + high)
    values, vectors = modes_near(pencil, middle, min(NEAREST, pencil.mass.shape[0] - 2))
    found, reach = list(zip(values, vectors.T, strict=True)), float(np.abs(values - middle).max())
    if reach < 0.5 * (high - low):
        found += _along_axis(pencil, low, middle.imag - reach) + _along_axis(pencil, middle.imag + reach, high)
    return found


def assembly_modes(scene: Scene, command: Command, fastest: float, resting: Resting) -> tuple[Assembly, list[Mode]]:
    """Assembly of a string, and its lateral modes that stay where they are when the cut is moved.

    Each has its changes on a mesh half as fine, and there with the cut moved from `ABOVE` to `MOVED`.

    Raises:
        RunError: There is no balance.
    """
    coarse = lateral_modes(assembly_of(scene, command, fastest, resting), fastest)
    moved = lateral_modes(assembly_of(scene, command, fastest, resting, above=MOVED), fastest)
    assembly, kept = assembly_of(scene, command, fastest, resting, finer=2), []
    fine = lateral_modes(assembly, fastest)
    for mode in coarse:
        away = _change(mode, moved)
        if fine and abs(away) < STAYS * abs(mode.eigenvalue):
            change = _change(mode, fine)
            same = next(other for other in fine if other.eigenvalue == mode.eigenvalue + change)
            kept.append(same._replace(number=len(kept) + 1, change=change, cut_change=away))
    return assembly, kept


def modes_along(assembly: Assembly) -> tuple[list[Mode], float]:
    """Torsional and axial modes of the whole string, held across by the hole, and the size up to which all are known."""
    equations, frame = assembly.equations, assembly.frame
    along, nodes = frame.along.copy(), frame.along.shape[0]
    along[0] = frame.bit @ along[0]
    directions = np.zeros((nodes, 7, 3))
    directions[:, 0:3, 0] = directions[:, 3:6, 1] = along
    directions[:, SPIN, 2] = 1.0
    directions[~equations.free] = 0.0
    row, column = np.repeat(np.arange(7 * nodes), 3), (3 * np.arange(nodes)[:, None, None] + np.arange(3)).repeat(7, 1)
    basis = sp.csr_array((directions.ravel(), (row, column.ravel())), shape=(7 * nodes, 3 * nodes))
    basis = basis[equations.free.ravel()]
    basis = basis[:, np.flatnonzero(abs(basis).sum(axis=0))]
    system, delay = assembly.linearised(assembly.command.rotation), equations.delay(assembly.command)
    own = Pencil(*system.sparse)
    pencil = own.on(basis)
    values, vectors = modes_near(pencil) if delay is None else delayed_modes(pencil, delay.on(basis))
    part, keep = np.arange(equations.unknowns), np.flatnonzero(values.imag >= 0.0)
    found = [classed(equations, frame, part, own.mass, complex(values[k]), basis @ vectors[:, k]) for k in keep]
    return found, float(np.abs(values).max())


def table_of(scene: Scene, command: Command, fastest: float, resting: Resting, count: int) -> ModeTable:
    """Lateral modes of the assembly of a long string, torsional and axial ones of the whole of it.

    Args:
        scene: The scene.
        command: Weight on bit and rotation.
        fastest: Rotation up to whose frequency lateral modes are sought [rad/s].
        resting: Balance of a string.
        count: Torsional and axial modes; of lateral ones all are given.

    Raises:
        RunError: There is no balance.
    """
    assembly, lateral = assembly_modes(scene, command, fastest, resting)
    others, reach = modes_along(assembly)
    kept, growing, creeping = listed([*lateral, *others], count=max(count, len(lateral)))
    balance = Balance(command, assembly.u, assembly.linearised(command.rotation))
    return ModeTable(balance, False, kept, growing, creeping, reach, assembly)


def _change(mode: Mode, others: list[Mode]) -> complex:
    """Change to the nearest eigenvalue; NaN where there is none."""
    changes = (other.eigenvalue - mode.eigenvalue for other in others)
    return min(changes, key=abs, default=complex(math.nan, math.nan))
