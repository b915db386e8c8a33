# SPDX-License-Identifier: Apache-2.0
"""Lateral modes of the bottom-hole assembly of a long string about its balance on the low side.

A mode of the assembly stays where it is when the cut is moved; a mode that moves belongs to the pipe and is left out.
Torsional and axial modes are modes of the whole string.
"""

import math
from typing import Any

import numpy as np
from scipy.sparse import csc_array

from drill_twin.core.arrays import ComplexArray
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.assembly import MOVED, Assembly, FindBalance, assembly_of
from drill_twin.dynamics.rotordynamics.block_rows import banded
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, modes_near, rounding
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import (
    AXIAL,
    LATERAL,
    TORSIONAL,
    Balance,
    Mode,
    ModeTable,
    classed,
    listed,
)
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame
from drill_twin.physics.model import SPIN
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

Spectrum = list[tuple[complex, ComplexArray]]
"""Eigenvalues with their shapes."""
NEAREST = 60
"""Eigenvalues computed around a point of the imaginary axis, and least number of these of motion along the hole."""
REPEATS, CONVERGED, AWAY, FEW = 10, 1e-8, 0.03, 8
"""Most inverse iterations of a mode of the whole string, change of its eigenvalue, over its size, that ends them (each
squares the error), and change over all of them from which they go to another mode; eigenvalues computed then. Two to
four iterations were needed, and one mode in sixty went away; chosen."""
ROUGH, MAJORITY = 1e-6, 0.5
"""Error of a mode from which iterations begin (in a well the least error took 615 products in place of 122). And the
share of kinetic energy across the hole above which a mode that began along it is lateral: friction couples an axial
mode to pipe on the low side, which may take a fifth of it."""
SAME = 1e-6
"""Difference of two eigenvalues over their size up to which they are one, computed twice."""
STAYS = 0.01
"""Change of an eigenvalue, over its size, up to which a mode does not move with the cut."""
LIGHT = 0.15
"""Damping ratio below which a mode has a critical speed: above it, it is hardly felt."""
NEAR = 0.05
"""Step from one critical speed to the next, over the speed, below which both are in one range."""


def lateral_modes(
    assembly: Assembly, pencil: Pencil, fastest: float, spectrum: Spectrum | None = None
) -> list[tuple[Mode, ComplexArray]]:
    """Lateral modes up to the frequency of the fastest rotation [rad/s] whose motion is mostly in the assembly.

    By frequency, with their shapes by unknown; of all eigenvalues, or of some.
    """
    spectrum = spectrum or _along_axis(pencil, 0.0, fastest)
    found: list[tuple[Mode, ComplexArray]] = []
    inside = assembly.equations.model.rod.arc <= assembly.extent.assembly
    for value, vector in spectrum:
        if any(abs(value - mode.eigenvalue) < SAME * abs(value) for mode, _ in found):
            continue
        if 0.0 < value.imag <= fastest and -value.real < LIGHT * abs(value):
            mode = classed(
                assembly.equations, assembly.frame, assembly.part, pencil.mass, complex(value), vector, assembly.collars
            )
            if mode.kind == LATERAL and inside[int(np.argmax(np.abs(mode.shape)))]:
                found.append((mode, vector))
    return sorted(found, key=lambda pair: pair[0].eigenvalue.imag)


def _along_axis(pencil: Pencil, low: float, high: float) -> Spectrum:
    """Eigenvalues near a stretch of the imaginary axis [rad/s], without gaps, and their shapes; some of them twice."""
    middle = 0.5j * (low + high)
    values, vectors = modes_near(pencil, middle, min(NEAREST, pencil.mass.shape[0] - 2))
    found, reach = list(zip(values, vectors.T, strict=True)), float(np.abs(values - middle).max())
    if reach < 0.5 * (high - low):
        found += _along_axis(pencil, low, middle.imag - reach) + _along_axis(pencil, middle.imag + reach, high)
    return found


def assembly_modes(
    scene: Scene, command: Command, fastest: float, resting: FindBalance
) -> tuple[Assembly, Assembly, list[Mode]]:
    """Assembly on two meshes, and the lateral modes on the finer mesh that do not move with the cut.

    They are found on a mesh half as fine, and from there on the finer mesh, and on the first with the cut moved from
    `ABOVE` to `MOVED`. Each mode has its changes on these.

    Raises:
        RunError: There is no balance.
    """
    first = assembly_of(scene, command, fastest, resting)
    longer = assembly_of(scene, command, fastest, resting, above=MOVED, near=first)
    assembly = assembly_of(scene, command, fastest, resting, finer=2, near=first)
    pencil, moved, fine = (one.pencil(command.rotation, fastest) for one in (first, longer, assembly))

    def again(other: Assembly, own: Pencil, mode: Mode, shape: ComplexArray) -> tuple[Mode | None, complex]:
        near = lateral_modes(other, own, fastest, _refined(own, mode.eigenvalue, first.on(other, shape)))
        changes = ((one, one.eigenvalue - mode.eigenvalue) for one, _ in near)
        return min(changes, key=lambda pair: abs(pair[1]), default=(None, complex(math.nan, math.nan)))

    kept: list[Mode] = []
    for mode, shape in lateral_modes(first, pencil, fastest):
        _, away = again(longer, moved, mode, shape)
        if abs(away) < STAYS * abs(mode.eigenvalue):
            same, change = again(assembly, fine, mode, shape)
            if same and all(abs(same.eigenvalue - one.eigenvalue) > SAME * abs(same.eigenvalue) for one in kept):
                kept.append(same._replace(number=len(kept) + 1, change=change, cut_change=away))
    return first, assembly, kept


def in_trough(table: ModeTable, mode: Mode) -> bool:
    """True if what lies on the wall has more than half of the squared motion: it swings sideways in the trough."""
    part = table.assembly
    if mode.kind != LATERAL or part is None:
        return False
    motion = np.gradient(part.equations.model.rod.arc) * np.abs(mode.shape) ** 2
    return bool(motion @ part.lying > 0.5 * motion.sum())


def critical_ranges(table: ModeTable, trough: bool = False) -> list[list[float]]:
    """Critical speeds of the collars [rad/s], rising; in one list, with a step below `NEAR` from each to the next.

    Speeds of modes that move most between contacts, or of swings in the trough.

    Collars in their trough swing from sqrt(w sqrt(1 + mu^2) / (c m)) on, by the weight across the hole w and the mass m
    per length, the clearance c and the friction mu; each further half-wave adds a speed a little above it.
    """
    own = (mode for mode in table.of(LATERAL) if mode.of_collars and in_trough(table, mode) is trough)
    speeds = np.sort([mode.eigenvalue.imag for mode in own])
    gaps = np.flatnonzero(np.diff(speeds) >= NEAR * speeds[:-1])
    return [near.tolist() for near in np.split(speeds, gaps + 1) if near.size]


def table_of(scene: Scene, command: Command, fastest: float, resting: FindBalance, count: int) -> ModeTable:
    """Lateral modes of the assembly of a long string, and torsional and axial modes of the whole string.

    Args:
        scene: The scene.
        command: Weight on bit and rotation.
        fastest: Rotation up to whose frequency lateral modes are sought [rad/s].
        resting: Balance of a string.
        count: Number of torsional modes, and of axial modes; all lateral modes are given.

    Raises:
        RunError: There is no balance, or no rotation.
    """
    if command.rotation == 0.0:
        raise RunError(
            "expected a rotation for the modes of an assembly that lies on the wall, found 0 rad/s: friction holds a "
            "string that does not turn; give one, such as --rpm 120"
        )
    coarse, assembly, lateral = assembly_modes(scene, command, fastest, resting)
    whole, equations = coarse.linearised(command.rotation).sparse, coarse.equations
    found = modes_along(equations, whole, count)  # none is delayed: cutting needs its weight at the top
    reach = max(abs(mode.eigenvalue) for mode in found)
    others = [mode for kind in (TORSIONAL, AXIAL) for mode in listed(found, count)[0] if mode.kind == kind]
    kept, growing, creeping = listed([*lateral, *others], max(count, len(lateral)))
    balance = Balance(command, assembly.u, assembly.linearised(command.rotation))
    return ModeTable(scene, balance, False, kept, growing, creeping, reach, assembly)


def modes_along(equations: EquationsOfMotion, pencil: Pencil, count: int) -> list[Mode]:
    """Modes of a long string, the smallest first, up to `count` torsional and `count` axial modes.

    The nearest eigenvalues to zero are mostly lateral. So modes of the motion along and about the hole alone are sought
    first, and each then goes to a mode of all unknowns by inverse iteration.
    """
    start = _along(equations)
    values, vectors = modes_near(
        Pencil(*(start.T @ matrix @ start for matrix in pencil)),
        count=min(max(NEAREST, 6 * count), start.shape[1]),
        accuracy=ROUGH,
    )
    frame, part = HoleFrame.of(equations), np.arange(equations.unknowns)
    found: list[Mode] = []
    for k in np.argsort(np.abs(values)):
        if min(sum(mode.kind == kind for mode in found) for kind in (TORSIONAL, AXIAL)) >= count:
            break
        for value, shape in _refined(pencil, values[k], start @ vectors[:, k]) if values[k].imag >= 0.0 else ():
            if value.imag >= 0.0 and all(abs(value - mode.eigenvalue) > STAYS**2 * abs(value) for mode in found):
                off = rounding(pencil, np.array([value]), shape[:, None])[0]
                found.append(
                    classed(equations, frame, part, pencil.mass, complex(value), shape, off=off, mixed=MAJORITY)
                )
    return found


def _refined(pencil: Pencil, start: complex, shape: ComplexArray) -> Spectrum:
    """The mode near an approximate one, by inverse iteration; where it goes to another one, some modes about it.

    The sparse matrices have entries at the same places.
    """
    value, size = start, shape.size
    solve = banded(pencil.mass.indices, np.repeat(np.arange(size), np.diff(pencil.mass.indptr)), size)
    mass, damping, stiffness = (matrix.data for matrix in pencil)
    products = [matrix @ shape for matrix in pencil]
    for _ in range(REPEATS):
        before, right = value, 2.0 * value * products[0] + products[1]
        shape = solve(value**2 * mass + value * damping + stiffness, right)
        shape /= np.linalg.norm(shape)
        products = [matrix @ shape for matrix in pencil]
        roots = np.roots([shape.conj() @ product for product in products])
        value = roots[np.argmin(np.abs(roots - value))]
        if abs(value - start) > AWAY * abs(start):
            break
        if abs(value - before) <= CONVERGED * abs(value):
            return [(value, shape)]
    values, vectors = modes_near(pencil, start, FEW)
    return list(zip(values, vectors.T, strict=True))


def _along(equations: EquationsOfMotion) -> Any:
    """Motion of each node along the hole, its derivative by arc length, and spin, by unknown; sparse columns."""
    frame, arc = HoleFrame.of(equations), equations.model.rod.arc
    along, bend = frame.along.copy(), np.gradient(frame.along, arc, axis=0)
    along[0], bend[0] = frame.bit @ along[0], frame.bit @ bend[0]
    fields = np.zeros((3, arc.size, SPIN + 1))
    fields[0, :, 0:3], fields[0, :, 3:6], fields[1, :, 3:6], fields[2, :, SPIN] = along, bend, along, 1.0
    values, node = fields[:, :, equations.columns][:, equations.free], np.nonzero(equations.free)[0]
    row, column = np.broadcast_to(np.arange(node.size), values.shape), 3 * node + np.arange(3)[:, None]
    basis = csc_array((values.ravel(), (row.ravel(), column.ravel())), shape=(node.size, 3 * arc.size))
    return basis[:, np.flatnonzero(np.abs(basis).sum(axis=0) > 0.5)]  # without columns whose motion is held
