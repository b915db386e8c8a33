# SPDX-License-Identifier: Apache-2.0
"""Critical times without a run: the growth of the string on the axis, integrated along the ramps of load and rotation.

On the lowest modes of the string without load the motion across the axis, z = x + i y, obeys

``q'' + (tau K_b + c + b) q' + (K - F K_F - i Omega tau K_b) q = (bow + eccentricity Omega^2) exp(i theta)``,

with the load F and the rotation Omega at that time, tau the retardation time of bending, c the drag, b the friction of
the bit. The matrices come from the compiled effects of the scene; the wall is not in it, so it holds until the
string touches. Steps by the implicit midpoint rule.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.compile.jit import kernel
from drill_twin.core.compile.kernel_cache import load_generated
from drill_twin.dynamics.rotordynamics.eigenvalues import Pencil, undamped_basis
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import bit_unknowns
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame
from drill_twin.physics.model.mesh import SPIN
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.paper.runs.cases import changed
from drill_twin_evidence.paper.search.readings import MARKS
from drill_twin_evidence.paper.search.space import BIT, LOAD_SHAPE, ROTATION_SHAPE, Trial

MODES = 6
ELEMENTS = 20
STEP = 0.01
"""Time step [s]: sixteen steps in a period of the fastest motion that matters."""


class LinearString(NamedTuple):
    """Matrices of the string on the axis on r modes."""

    stiffness: Array
    """K without load, shape (r, r)."""
    by_load: Array
    """Change of K by a load of 1 N, shape (r, r)."""
    bending: Array
    """Bending part of K, shape (r, r)."""
    drag: Array
    """Damping by a drag of 1 N s/m^2, shape (r, r)."""
    bit: Array
    """Place of the bit across the axis, shape (r,); zero where it is held."""
    bow: Array
    """Force of a bow of 1 m, shape (r,)."""
    imbalance: Array
    """Force of an eccentricity of 1 m at 1 rad/s, shape (r,)."""
    marks: Array
    """Places of the marks, shape (m, r)."""
    hanging: float
    """Excess of the load at the bit over the set-point [N]."""


class Start(NamedTuple):
    """Inputs of a start besides the matrices."""

    load: float
    load_start: float
    load_duration: float
    load_step: float
    speed: float
    speed_duration: float
    speed_step: float
    bow: float
    eccentricity: float
    time: float
    drag: float
    bit_friction: float
    bit_radius: float


def linear_string(scene: Scene) -> LinearString:
    """Matrices of a scene in its lateral form, by its compiled effects.

    Args:
        scene: With `bow`, `eccentricity`, `internal_damping`, `drag`, `wall` and `bit_friction`, vertical.
    """
    scene = changed(scene, "numerics.elements", ELEMENTS)
    equations = EquationsOfMotion(scene)
    own = equations.parameters
    frame, none = TurningFrame(equations), own
    none = none._replace(
        internal_damping=own.internal_damping._replace(bending=0.0),
        drag=own.drag._replace(linear=0.0), bit_friction=own.bit_friction._replace(coefficient=0.0),
    )  # fmt: skip

    def at(parameters: Any, weight: float, rotation: float) -> tuple[Pencil, ComplexArray]:
        equations.parameters = parameters
        command = Command(weight, rotation)
        u, v = equations.on_axis(command)
        v[:, SPIN] = rotation
        system = equations.evaluate(command, u, v, np.zeros_like(u))
        force = system.residual[frame.x] + 1j * system.residual[frame.y]
        return Pencil(*(frame.as_complex(matrix) for matrix in system.matrices)), np.asarray(force)

    hanging = equations._bit_weight(Command(0.0, 0.0))  # noqa: SLF001
    still, _ = at(none, 0.0, 0.0)
    basis = undamped_basis(still, MODES)
    loaded, _ = at(none, 1.0, 0.0)
    damped, _ = at(none._replace(internal_damping=none.internal_damping._replace(bending=1.0)), 0.0, 0.0)
    dragged, _ = at(none._replace(drag=none.drag._replace(linear=1.0)), 0.0, 0.0)
    equations.set_imperfections(1.0)
    _, bowed = at(none, 0.0, 0.0)
    _, both = at(none, 0.0, 1.0)
    equations.set_imperfections(0.0)
    shape = np.zeros((equations.free.shape[0], MODES))
    shape[equations.free[:, 0]] = basis[frame.at_node]
    arc = equations.model.rod.arc
    places = {mark.name: mark.distance_from_bit for mark in scene.string.marks}
    marks = np.array([[np.interp(places[mark], arc, column) for column in shape.T] for mark in MARKS])
    bit = shape[0] if bit_unknowns(equations, frame).size else np.zeros(MODES)

    def real(matrix: NDArray[Any]) -> Array:
        return np.ascontiguousarray((basis.T @ matrix @ basis).real)

    amplitude, offset = scene.effects.bow.amplitude, scene.effects.eccentricity.offset
    return LinearString(
        real(still.stiffness), real(loaded.stiffness - still.stiffness), real(damped.damping - still.damping),
        real(dragged.damping - still.damping), bit, -(basis.T @ bowed).real / amplitude,
        -(basis.T @ (both - bowed)).real / offset, marks, float(hanging),
    )  # fmt: skip


@kernel
def level(time: float, start: float, duration: float, cubic: float) -> float:
    """Share of a set-point that is reached: a straight line, or a STEP where `cubic` is 1."""
    x = min(max((time - start) / duration, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x) if cubic > 0.5 else x


@kernel
def grow(string: Any, start: Any, work: ComplexArray, limits: Array, step: float, end: float, out: Array) -> None:
    """Integrate from rest on the axis until mark_2 and any mark have passed the last limit.

    Args:
        string: Matrices.
        start: Loads, ramps, imperfections.
        work: Room, shape (r, r + 5).
        limits: Displacements [m], rising, shape (k,).
        step: Time step [s].
        end: Latest time [s].
        out: First time beyond each limit at any mark and at mark_2 [s], shape (k, 2); NaN where there is none.
    """
    r = string.bit.size
    q, v, rhs = work[:, r], work[:, r + 1], work[:, r + 2]
    work[:] = 0.0
    out[:] = np.nan
    theta, time = 0.0, 0.0
    while time < end:
        middle = time + 0.5 * step
        load = start.load * level(middle, start.load_start, start.load_duration, start.load_step)
        rotation = start.speed * level(middle, 0.0, start.speed_duration, start.speed_step)
        angle = theta + 0.5 * step * rotation
        turn = complex(np.cos(angle), np.sin(angle))
        slide = 0.0 + 0.0j
        for i in range(r):
            slide += string.bit[i] * v[i]
        rim = start.bit_radius * rotation
        brake = start.bit_friction * max(load + string.hanging, 0.0)
        brake /= np.sqrt(slide.real**2 + slide.imag**2 + rim * rim + 1e-12)
        # (I / h + C / 2 + h K / 4) dv = f - C v - K (q + h v / 2)
        for i in range(r):
            total = (start.bow * string.bow[i] + start.eccentricity * rotation * rotation * string.imbalance[i]) * turn
            for j in range(r):
                c = start.time * string.bending[i, j] + start.drag * string.drag[i, j]
                c += brake * string.bit[i] * string.bit[j]
                k = string.stiffness[i, j] + load * string.by_load[i, j]
                k -= 1j * rotation * start.time * string.bending[i, j]
                total -= c * v[j] + k * (q[j] + 0.5 * step * v[j])
                work[i, j] = 0.5 * c + 0.25 * step * k
            work[i, i] += 1.0 / step
            rhs[i] = total
        for i in range(r):  # no pivoting: the diagonal is the largest
            for j in range(i + 1, r):
                factor = work[j, i] / work[i, i]
                for k in range(i + 1, r):
                    work[j, k] -= factor * work[i, k]
                rhs[j] -= factor * rhs[i]
        for m in range(r):
            i = r - 1 - m
            for j in range(i + 1, r):
                rhs[i] -= work[i, j] * rhs[j]
            rhs[i] /= work[i, i]
        for i in range(r):
            q[i] += step * (v[i] + 0.5 * rhs[i])
            v[i] += rhs[i]
        time += step
        theta += step * rotation
        most, second = 0.0, 0.0
        for m in range(string.marks.shape[0]):
            place = 0.0 + 0.0j
            for i in range(r):
                place += string.marks[m, i] * q[i]
            size = np.sqrt(place.real**2 + place.imag**2)
            most = max(most, size)
            if m == 1:
                second = size
        for n in range(limits.size):
            if most >= limits[n] and np.isnan(out[n, 0]):
                out[n, 0] = time
            if second >= limits[n] and np.isnan(out[n, 1]):
                out[n, 1] = time
        if not np.isnan(out[limits.size - 1, 1]) or not most < 1e3:
            return


_MODULE = '''"""Growth along the ramps. Generated by drill_twin; do not edit."""
from drill_twin.core.compile.jit import entry_kernel
from drill_twin_evidence.paper.search import growth


@entry_kernel
def grow(string, start, work, limits, step, end, out):
    growth.grow(string, start, work, limits, step, end, out)
'''


@cache
def compiled() -> Any:
    """Entry point `grow`."""
    return load_generated("paper_growth", _MODULE).grow


def critical_times(string: LinearString, start: Start, limits: Array, end: float) -> Array:
    """First times beyond each limit at any mark and at mark_2 [s], flat, shape (2 k,); NaN where there is none."""
    r = string.bit.size
    out = np.empty((limits.size, 2))
    compiled()(string, start, np.empty((r, r + 5), dtype=complex), limits, STEP, end, out)
    return out.ravel()


def start_of(one: Trial, weight: float, speed: float) -> Start:
    """The start of a set at a load [N] and a speed [rev/s]."""
    own = one.number
    return Start(
        weight, own("start of the load"), own("ramp of the load"), float(one.choices[LOAD_SHAPE]),
        speed * math.tau, own("ramp of the rotation"), float(one.choices[ROTATION_SHAPE]),
        own("bow"), own("eccentricity"), own("retardation time"), own("drag"),
        own("friction at the bit") if one.choices[BIT] == 0 else 0.0, own("radius at which the bit rubs"),
    )  # fmt: skip
