# SPDX-License-Identifier: Apache-2.0
"""Loads, margins and contacts of a scene in each operation of the rig."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, RunError, nearest
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.torque_drag.along_string import AlongString, along_string, hole_and_string, stop_text
from drill_twin.dynamics.torque_drag.sliding_balance import BalancedString, SlidingBalance, steady
from drill_twin.dynamics.torque_drag.soft_string import (
    BucklingLoads,
    BucklingState,
    HoleAndString,
    Operation,
    SoftString,
    lock_up_weight,
    soft_string,
    straight_weight,
)
from drill_twin.scene import Scene

VERTICAL = math.radians(0.1)
"""Inclination below which a hole has no low side [rad]; surveys are not more accurate. Chosen, not measured."""
NO_TORQUE = 1e-4
"""Torque over make-up torque below which a connection is not loaded; Newton's residual is of that size."""


class ContactLoad(NamedTuple):
    """Bit or stabiliser on the wall of the hole."""

    name: str
    distance_from_bit: float
    """Of its middle [m]."""
    force: float
    """Across the hole [N]."""
    tilt: float
    """Angle between string and hole [rad]."""
    build: float = math.nan
    """Of the bit: force of the wall towards the low side [N]. Above zero the bit presses on the high side and builds
    angle, below it drops; NaN where the hole is vertical (`VERTICAL`), and of other contacts."""
    walk: float = math.nan
    """Of the bit: force of the wall to the left, seen down the hole with the high side up [N]. Above zero the bit
    presses to the right; NaN as `build`."""
    lift: float = math.nan
    """Of the bit: part of the tilt in the plane of high and low side [rad]; above zero the bit points to the high side;
    NaN as `build`."""


class OperationLoads(NamedTuple):
    """Loads of the string in an operation."""

    balance: BalancedString
    along: AlongString
    soft: SoftString
    buckling: BucklingLoads
    states: Array
    """`BucklingState` of each element."""
    bit_torque: float
    """[N m]."""
    lock_up: float
    """Weight on bit at which sliding takes the whole hookload [N]; NaN where the bit carries no weight."""
    yield_margin: float
    """Yield strength over the largest equivalent stress; NaN in a string without `yield_strength`."""
    make_up_margin: float
    """Make-up torque over torque, where least; infinite without torque, NaN in a string without `make_up_torque`."""
    contacts: tuple[ContactLoad, ...]
    """The bit, then the stabilisers from the bit up."""

    @property
    def operation(self) -> Operation:
        """The operation."""
        return self.balance.operation

    @property
    def hookload(self) -> float:
        """[N]."""
        return self.balance.hookload

    @property
    def surface_torque(self) -> float:
        """[N m]."""
        return self.balance.surface_torque

    @property
    def neutral_point(self) -> float:
        """Distance from the bit of the uppermost change from compression to tension [m]; 0 if all is in tension."""
        tension = self.along.tension
        below = np.flatnonzero(tension < 0.0)
        if not below.size:
            return 0.0
        k = int(below[-1])
        distance = self.length - self.along.depth
        if k + 1 == tension.size:
            return self.length
        share = tension[k] / (tension[k] - tension[k + 1])
        return float(distance[k] + share * (distance[k + 1] - distance[k]))

    @property
    def length(self) -> float:
        """Length of the string [m]."""
        return float(self.along.length.sum())

    @property
    def stretch(self) -> float:
        """Elongation of the string [m]."""
        return float(np.sum(self.along.strain * self.along.length))

    @property
    def twist(self) -> float:
        """Twist between bit and top [rad]."""
        return float(np.sum(self.along.twist * self.along.length))

    @property
    def margins(self) -> tuple[float, float]:
        """Least of sinusoidal and of helical buckling load over compression; infinite without compression."""
        return self.buckling.margins(self.along.tension)

    @property
    def worst_state(self) -> BucklingState:
        """Buckling state that goes furthest."""
        return BucklingState(int(self.states.max()))


@dataclass(frozen=True, eq=False)
class Statics:
    """Loads of a scene in the operations of the rig."""

    scene: Scene
    operations: tuple[OperationLoads, ...]
    notes: Mapping[str, str] = field(default_factory=dict)
    """Sentence on each operation without a balance, or with a push from the top, by its name."""

    def __getitem__(self, name: str) -> OperationLoads:
        """Loads in an operation, by its name.

        Raises:
            ArgumentError: There is no such operation.
            RunError: The operation has no balance.
        """
        if name in (known := {loads.operation.name: loads for loads in self.operations}):
            return known[name]
        if name in self.notes:
            raise RunError(self.notes[name])
        raise ArgumentError(f'expected one of {", ".join(known)}, found "{name}"{nearest(str(name), known)}')


def analyse(scene: Scene, operations: Sequence[Operation]) -> Statics:
    """Balance, soft string and margins of a scene in each operation.

    Args:
        scene: The scene; elements given or `auto`.
        operations: Operations of the rig.

    Raises:
        RunError: No operation has a balance.
    """
    own = steady(scene)
    balance = SlidingBalance(EquationsOfMotion(own))
    string = hole_and_string(scene, balance.equations.model)
    found, notes = [], dict[str, str]()
    for operation in operations:
        try:
            found.append(_loads(own, balance, string, operation))
            if operation.axial_speed < 0.0 and found[-1].hookload < 0.0:
                held = stop_text(own, balance.equations.model, operation)
                notes[operation.name] = f"{operation.name}: the top has to push, its hookload is below 0{held}"
            if (why := own.string.backs_off) and operation.rotation < 0.0:
                notes[operation.name] = f"{operation.name}: turns to the left: {why}; no margin of make-up holds"
        except RunError as error:
            notes[operation.name] = str(error)
    if not found:
        raise RunError(next(iter(notes.values())))
    return Statics(scene, tuple(found), notes)


def _loads(scene: Scene, solver: SlidingBalance, string: HoleAndString, operation: Operation) -> OperationLoads:
    equations = solver.equations
    model, wall = equations.model, getattr(equations.parameters, "wall", None)
    try:
        balance = solver.solve(operation)
    except RunError:
        straight, most = straight_weight(string, operation), lock_up_weight(string, operation)
        if operation.axial_speed < 0.0 and most == 0.0:
            raise RunError(
                f'{scene.name}: expected a balance in the operation "{operation.name}", found none'
                f"{stop_text(scene, model, operation)}. Take less friction, or rotate"
            ) from None
        if not operation.weight_on_bit > min(straight, most):
            raise
        given, bent, pushed = (scene.unit_system.text(w, "force") for w in (operation.weight_on_bit, straight, most))
        raise RunError(
            f'{scene.name}: expected a balance in the operation "{operation.name}", found none at {given}: by the soft '
            f"string its pipe buckles from {bent} on, and takes at most {pushed} without a push. Take less (--wob)"
        ) from None
    along = along_string(scene, model, wall, balance.u)
    buckling = string.buckling(along.tension)
    torque = np.abs(along.torque)
    bit_torque = float(along.torque[0]) if operation.is_on_bottom else 0.0
    own_yield = np.array([section.yield_strength or math.nan for section in scene.string.sections])[model.section]
    own_torque = np.array([section.make_up_torque or math.nan for section in scene.string.sections])[model.section]
    loaded = ~(torque < NO_TORQUE * own_torque)
    return OperationLoads(
        balance, along, soft_string(string, operation, bit_torque), buckling, buckling.states(along.tension),
        bit_torque, lock_up_weight(string, operation) if operation.is_on_bottom else math.nan,
        least(own_yield / np.maximum(along.stress, 1e-300)),
        least(np.divide(own_torque, torque, out=np.full_like(torque, np.inf), where=loaded)),
        _contacts(scene, solver, balance, along),
    )  # fmt: skip


def least(margins: Array) -> float:
    """Least of the margins that are known; NaN if none is."""
    known = margins[~np.isnan(margins)]
    return float(known.min()) if known.size else math.nan


def _contacts(
    scene: Scene, solver: SlidingBalance, balance: BalancedString, along: AlongString
) -> tuple[ContactLoad, ...]:
    rod = solver.equations.model.rod
    tilts = np.linalg.norm(np.cross(balance.u[:, 3:6], solver.tangent), axis=1)
    inclination, along_hole = solver.equations.model.inclination, solver.tangent.reshape(-1, 3)[0]
    low = np.array([math.sin(inclination), 0.0, -math.cos(inclination)])
    low -= (low @ along_hole) * along_hole
    steep = float(np.linalg.norm(low))
    low = low / steep if steep > VERTICAL else np.full(3, math.nan)
    sides = np.stack([low, np.cross(low, along_hole)])  # to the low side, and to the left
    build, walk = (sides @ solver.equations.bit_frame[:, :3].T @ balance.bit[:3]).tolist()
    tilt, lift = math.asin(min(float(tilts[0]), 1.0)), float(balance.u[0, 3:6] @ low)
    found, bottom = [ContactLoad("bit", 0.0, balance.bit_side_force, tilt, build, walk, lift)], 0.0
    for number, section in enumerate(scene.string.sections):
        top = bottom + section.length
        if (
            section.blade_diameter is not None and section.adjusted_mass is None
        ):  # pipe with an adjusted mass lies on its tool joints
            inside = (rod.arc[:-1] >= bottom - 1e-9) & (rod.arc[1:] <= top + 1e-9)
            force = float(np.sum((along.side_force * rod.length)[inside]))
            node = int(np.argmin(np.abs(rod.arc - 0.5 * (bottom + top))))
            name = section.name or f"section {number + 1}"
            found.append(ContactLoad(name, 0.5 * (bottom + top), force, math.asin(min(float(tilts[node]), 1.0))))
        bottom = top
    return tuple(found)
