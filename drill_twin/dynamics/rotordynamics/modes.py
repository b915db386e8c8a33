# SPDX-License-Identifier: Apache-2.0
"""Damped modes of the turning string about its balance under the load.

In a straight vertical hole the balance is the string on the axis. Its lateral motion z = x + i y then obeys complex
equations of half the size, M z'' + (C) z' + K z = 0, in which forward whirl (in the sense of the rotation) has a
positive frequency and backward whirl a negative one (Genta 2005, ch. 2). Motion along and about the axis is separate.
Elsewhere the string lies on the wall, and all motions are coupled.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics.eigenvalues import (
    MOST_UNKNOWNS,
    Delay,
    Numbers,
    Pencil,
    at_least,
    damped_modes,
    delayed_modes,
    normed,
    rounding,
)
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, Linearised
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame, TurningFrame
from drill_twin.dynamics.solver.linearisation import STIFFNESS
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

if TYPE_CHECKING:
    from drill_twin.dynamics.rotordynamics.assembly import Assembly

NEWTON_STEPS = 30
NEWTON_TOLERANCE = 1e-9
LATERAL, TORSIONAL, AXIAL = "lateral", "torsional", "axial"
COUNT = 12
PLANE = 0.7
"""Share of the squared shape that makes a plane: friction takes the string up the wall, and turns both."""
MIXED = 0.1
"""Share of the kinetic energy across the hole from which a mode is lateral."""
CREEP = 1e-6
"""Largest frequency over the size of an eigenvalue of a motion without oscillation."""

Resting = Callable[[Command], Array]
"""Rows of the string in static balance under a command, twisted by the torques on it."""


class Mode(NamedTuple):
    """A damped mode, displacement Re(shape exp(eigenvalue t))."""

    kind: str
    """`lateral`, `torsional` or `axial`, by its kinetic energy."""
    eigenvalue: complex
    """Growth [1/s] and angular frequency [rad/s]; positive in the sense of rotation for lateral modes on the axis."""
    shape: ComplexArray
    """x + i y [m] (in an inclined hole low + i side), angle [rad] or displacement along the axis [m] at the nodes from
    the bit, largest 1; (n + 1,)."""
    number: int = 0
    """Among the modes of its kind, by the size of the eigenvalue, from 1."""
    change: complex = complex(math.nan, math.nan)
    """Change of the eigenvalue on a mesh twice as fine, not less than `rounding`; NaN: not known."""
    cut_change: complex = complex(math.nan, math.nan)
    """Change of the eigenvalue of a mode of the assembly where more pipe is added above it; NaN for other modes."""
    rounding: float = 0.0
    """Bound of the error of the eigenvalue by rounding [1/s]."""
    share: float = 1.0
    """Share of the kinetic energy of a mode of the assembly in its collars; 1 for other modes."""

    @property
    def of_collars(self) -> bool:
        """True if more than half of that is in the collars; else pipe moves that lies in its trough."""
        return self.share > 0.5

    @property
    def growth(self) -> float:
        """Rate of growth [1/s]; negative: it decays."""
        return self.eigenvalue.real

    @property
    def frequency(self) -> float:
        """Frequency [Hz], with the sign of the eigenvalue."""
        return self.eigenvalue.imag / math.tau

    @property
    def plane(self) -> str:
        """Of a lateral mode in an inclined hole: `up-down`, `sideways`, or `both`."""
        low = float(np.sum(self.shape.real**2) / np.sum(np.abs(self.shape) ** 2))
        return "up-down" if low > PLANE else "sideways" if low < 1.0 - PLANE else "both"

    @property
    def is_creep(self) -> bool:
        """True for a decay without oscillation, as of a short wave under much damping of the material."""
        return self.growth < 0.0 and abs(self.eigenvalue.imag) <= CREEP * abs(self.eigenvalue)

    @property
    def damping_ratio(self) -> float:
        """Minus the growth over the size of the eigenvalue [-]."""
        return -self.growth / max(abs(self.eigenvalue), 1e-300)


class Balance(NamedTuple):
    """The string in balance, turning without whirl, and its equations there."""

    command: Command
    u: Array
    """Rows (r, r', psi), shape (n + 1, 7)."""
    system: Linearised


class ModeTable(NamedTuple):
    """Modes about a balance."""

    scene: Scene
    balance: Balance
    on_axis: bool
    """True if the string is on the axis of the hole, so that frequencies of lateral modes have a sense."""
    modes: tuple[Mode, ...]
    """Lateral, torsional, axial: of each kind the smallest eigenvalues and the mode that grows fastest."""
    growing: dict[str, int]
    """Number of modes that grow, by kind."""
    creeping: dict[str, float]
    """Decay [1/s] of the slowest motion without oscillation, by kind, where there is one; it is no mode."""
    reach: float
    """Size of the eigenvalues up to which all are computed [rad/s]; finite in a large string."""
    assembly: Assembly | None = None
    """The part of a long string whose lateral modes these are; None: the whole string."""

    def of(self, kind: str) -> tuple[Mode, ...]:
        """Modes of one kind."""
        return tuple(mode for mode in self.modes if mode.kind == kind)

    def fastest(self, kind: str) -> Mode | None:
        """Mode of one kind that grows fastest, or decays slowest."""
        return max(self.of(kind), key=lambda mode: mode.growth, default=None)

    def nearest_critical(self) -> float:
        """Critical speed nearest to the rotation [rad/s], of its collars; NaN without one or without rotation."""
        rotation = self.balance.command.rotation
        collars = [mode for mode in self.of(LATERAL) if mode.of_collars]
        forward = (mode for mode in collars if not self.on_axis or mode.frequency * rotation > 0.0)
        speeds = (abs(mode.eigenvalue.imag) for mode in forward)
        return min(speeds, key=lambda speed: abs(speed - abs(rotation)), default=math.nan) if rotation else math.nan


def is_vertical(equations: EquationsOfMotion) -> bool:
    """True in a straight vertical hole, where the axis is a balance."""
    return equations.model.inclination == 0.0 and equations.model.wellbore.axis is None


def balance(equations: EquationsOfMotion, command: Command, resting: Resting | None = None) -> Balance:
    """Balance of the turning string by Newton's method, friction on bit and wall included.

    Args:
        equations: Of the scene.
        command: Weight on bit and rotation.
        resting: Static balance to start from, needed where the hole is not vertical.

    Raises:
        RunError: Newton's method does not converge.
    """
    u, v = equations.on_axis(command)
    if not is_vertical(equations):
        if resting is None:
            raise RunError("expected a balance in an inclined hole, found none; drill-twin run needs none")
        u = resting(command)
    still = np.zeros_like(u)
    for _ in range(NEWTON_STEPS):
        system = equations.evaluate(command, u, v, still)
        if not system.residual.any():
            return Balance(command, u, system)
        step = -system.rows.solve(system.tangents[STIFFNESS], system.residual)
        u, size = u + equations.rows(step), float(np.abs(step).max())
        if size < NEWTON_TOLERANCE * equations.scene.length:
            return Balance(command, u, equations.evaluate(command, u, v, still))
        if not np.isfinite(size):
            break
    point = equations.scene.unit_system.set_point(command.weight_on_bit, command.rotation)
    remedy = "try another, or --without wall_friction" if equations.scene.effects.wall_friction else "try another"
    raise RunError(
        f"{equations.scene.name}: expected a balance of the turning string at {point}, found none: Newton's method "
        f"does not converge. A string that slides on the wall may have none at this speed; {remedy}"
    )


def modes(
    equations: EquationsOfMotion, command: Command, resting: Resting | None = None, count: int = COUNT
) -> ModeTable:
    """Damped modes about the balance.

    Args:
        equations: Of the scene.
        command: Weight on bit and rotation.
        resting: As in `balance`.
        count: Modes of each kind, with the smallest eigenvalues.

    Raises:
        RunError: There is no balance.
    """
    found = balance(equations, command, resting)
    frame, system, delay = TurningFrame(equations), found.system, equations.delay(command)
    pencil = system.matrices if is_vertical(equations) or equations.unknowns <= MOST_UNKNOWNS else system.sparse
    on_axis = is_vertical(equations) and all(frame.is_isotropic(matrix) for matrix in pencil)
    if on_axis:
        all_modes = _lateral(equations, frame, pencil)
        reach = _reach(all_modes, frame.x.size)
        if frame.rest.size:
            part, about = np.ix_(frame.rest, frame.rest), delay and delay.of(frame.rest)
            others = coupled_modes(equations, frame.rest, Pencil(*(matrix[part] for matrix in pencil)), about)
            all_modes, reach = all_modes + others, min(reach, _reach(others, frame.rest.size))
    else:
        all_modes = coupled_modes(equations, np.arange(equations.unknowns), pencil, delay)
        reach = _reach(all_modes, equations.unknowns)
    return ModeTable(equations.scene, found, on_axis, *listed(all_modes, count), reach)


def listed(all_modes: list[Mode], count: int) -> tuple[tuple[Mode, ...], dict[str, int], dict[str, float]]:
    """Modes of a table with their numbers, how many grow, and the slowest decays without oscillation, by kind."""
    kept: list[Mode] = []
    growing: dict[str, int] = {}
    creeping: dict[str, float] = {}
    for kind in (LATERAL, TORSIONAL, AXIAL):
        own = sorted((mode for mode in all_modes if mode.kind == kind), key=lambda mode: abs(mode.eigenvalue))
        swinging = [mode for mode in own if not mode.is_creep]
        numbered = [mode._replace(number=number) for number, mode in enumerate(swinging, 1)]
        fastest = max(numbered, key=lambda mode: mode.growth, default=None)
        kept += [mode for mode in numbered if mode.number <= count or (mode is fastest and mode.growth > 0.0)]
        growing[kind] = sum(mode.growth > 0.0 for mode in numbered)
        if slowest := [-mode.growth for mode in own if mode.is_creep]:
            creeping[kind] = min(slowest)
    return tuple(kept), growing, creeping


def compared(table: ModeTable, finer: ModeTable) -> ModeTable:
    """The table with the change of each eigenvalue to the nearest eigenvalue of its kind on a finer mesh."""
    from scipy.optimize import linear_sum_assignment  # takes 0.2 s, which modes of a long string do not need

    kept: list[Mode] = []
    for kind in (LATERAL, TORSIONAL, AXIAL):
        own, others = table.of(kind), finer.of(kind)
        apart = np.array([[other.eigenvalue - mode.eigenvalue for other in others] for mode in own])
        pairs = zip(*linear_sum_assignment(np.abs(apart)), strict=True) if apart.size else ()
        change = {row: at_least(apart[row, at], own[row].rounding, others[at].rounding) for row, at in pairs}
        kept += [mode._replace(change=change.get(row, mode.change)) for row, mode in enumerate(own)]
    return table._replace(modes=tuple(kept))


def _reach(found: list[Mode], size: int) -> float:
    """Size of the largest eigenvalue where only the eigenvalues nearest to zero are computed [rad/s]; else infinity."""
    return max(abs(mode.eigenvalue) for mode in found) if size > MOST_UNKNOWNS else math.inf


def _lateral(equations: EquationsOfMotion, frame: TurningFrame, pencil: Pencil) -> list[Mode]:
    """Modes on z = x + i y."""
    whole = Pencil(*(frame.as_complex(matrix) for matrix in pencil))
    values, vectors = damped_modes(whole)
    shapes, off = np.zeros((equations.free.shape[0], values.size), complex), rounding(whole, values, vectors)
    shapes[equations.free[:, 0]] = vectors[frame.at_node]
    return [Mode(LATERAL, complex(value), normed(shapes[:, k]), rounding=off[k]) for k, value in enumerate(values)]


def coupled_modes(equations: EquationsOfMotion, part: Numbers, pencil: Pencil, delay: Delay | None) -> list[Mode]:
    """Modes of real equations, one of each conjugate pair, classed by the modes' kinetic energy."""
    values, vectors = damped_modes(pencil) if delay is None else delayed_modes(pencil, delay)
    keep, off = np.flatnonzero(values.imag >= 0.0), rounding(pencil, values, vectors)
    frame = HoleFrame.of(equations)
    return [classed(equations, frame, part, pencil.mass, values[k], vectors[:, k], off=off[k]) for k in keep]


def classed(
    equations: EquationsOfMotion, frame: HoleFrame, part: Numbers, mass: Any, value: complex, vector: ComplexArray,
    collars: float = math.inf, off: float = 0.0, mixed: float = MIXED,
) -> Mode:  # fmt: skip
    """Mode of some of the unknowns: lateral, or of the kind along the hole that has more of its kinetic energy.

    Lateral is a mode with more than a share `mixed` of its kinetic energy across the hole. Its shape there is low + i
    side at the instant of the largest displacement; `share` up to `collars` [m].
    """
    whole = np.zeros((2, equations.unknowns), dtype=complex)
    whole[:, part] = vector, mass @ vector
    rows, momenta = (frame.local(equations.rows(one)) for one in whole)
    energy = np.abs(rows) * np.abs(momenta)
    own = {LATERAL: energy[:, [0, 1, 3, 4]], AXIAL: energy[:, [2, 5]], TORSIONAL: energy[:, 6]}
    shares = {key: float(part.sum()) for key, part in own.items()}
    is_lateral = shares[LATERAL] > mixed * sum(shares.values())  # friction takes twist and stretch along
    kind = LATERAL if is_lateral else max((AXIAL, TORSIONAL), key=shares.__getitem__)
    largest = (rows[:, 0] ** 2 + rows[:, 1] ** 2)[int(np.argmax(np.abs(rows[:, 0]) ** 2 + np.abs(rows[:, 1]) ** 2))]
    at = (rows * np.exp(-0.5j * np.angle(largest))).real
    shape = {LATERAL: at[:, 0] + 1j * at[:, 1], AXIAL: rows[:, 2], TORSIONAL: rows[:, 6]}[kind]
    share = float(energy[equations.model.rod.arc <= collars].sum() / energy.sum())
    peak = shape[int(np.argmax(np.abs(shape)))]  # of a lateral mode to the low side or sideways: figures have one sign
    shape = shape / np.copysign(abs(peak), peak.real + peak.imag) if kind == LATERAL else normed(shape)
    return Mode(kind, complex(value), shape, share=share, rounding=off)
