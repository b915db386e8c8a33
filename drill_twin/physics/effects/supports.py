# SPDX-License-Identifier: Apache-2.0
"""Elastic supports and bearings of the string (`string.supports`), at a node of the mesh; a part of the string."""

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Damping, RotationalDamping, RotationalStiffness, Stiffness, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.effects.discs import PartName, PartPlace
from drill_twin.physics.model import DiscreteModel, Rod, transverse_axes

Spring = Annotated[Stiffness, Within(at_least="0 N/m", at_most="1e15 N/m")]
Damper = Annotated[Damping, Within(at_least="0 N s/m", at_most="1e12 N s/m")]
CrossSpring = Annotated[Stiffness, Within(at_least="-1e15 N/m", at_most="1e15 N/m")]
CrossDamper = Annotated[Damping, Within(at_least="-1e12 N s/m", at_most="1e12 N s/m")]


class Support(EffectConfig):
    """Elastic support, bearing or elastic root, linear, without play: across the hole and against tilt from its axis.

    x is the low side of an inclined hole. A root has a `tilt_stiffness` at an end that is `pinned` or `hinged`.
    """

    name: PartName
    """Name in reports."""
    distance_from_bit: PartPlace
    """Arc length from the bit [m]; a node of the mesh is put there."""
    stiffness: Spring = 0.0
    """Stiffness across, in x, and in y where no other is given [N/m]."""
    stiffness_y: Spring | None = None
    """Stiffness in y [N/m]; left out: as in x."""
    stiffness_xy: CrossSpring = 0.0
    """Force in x by displacement in y [N/m]: of oil films."""
    stiffness_yx: CrossSpring = 0.0
    """Force in y by displacement in x [N/m]."""
    damping: Damper = 0.0
    """Damping across, in x, and in y where no other is given [N s/m]."""
    damping_y: Damper | None = None
    """Damping in y [N s/m]; left out: as in x."""
    damping_xy: CrossDamper = 0.0
    """Force in x by speed in y [N s/m]."""
    damping_yx: CrossDamper = 0.0
    """Force in y by speed in x [N s/m]."""
    tilt_stiffness: Annotated[RotationalStiffness, Within(at_least="0 N m/rad", at_most="1e15 N m/rad")] = 0.0
    """Stiffness against tilt from the axis of the hole, in both directions [N m/rad]."""
    tilt_damping: Annotated[RotationalDamping, Within(at_least="0 N m s/rad", at_most="1e12 N m s/rad")] = 0.0
    """Damping of tilt [N m s/rad]."""

    def problems(self) -> Iterator[Problem]:
        """A support that holds nothing."""
        if not any(getattr(self, key) for key in type(self).model_fields if key not in ("name", "distance_from_bit")):
            yield (), "expected a stiffness or a damping above 0, found none"

    @property
    def is_isotropic(self) -> bool:
        """True if it acts alike in all directions across."""
        alike = self.stiffness_y in (None, self.stiffness) and self.damping_y in (None, self.damping)
        return alike and self.stiffness_xy == -self.stiffness_yx and self.damping_xy == -self.damping_yx


class Parameters(NamedTuple):
    """The s supports as the kernel takes them."""

    node: NDArray[np.int64]  # (s,)
    frame: Array  # directions x and y across the hole, and the place on its axis [m], shape (s, 3, 3)
    spring: Array  # [N/m], shape (s, 2, 2)
    damper: Array  # [N s/m], shape (s, 2, 2)
    tilt: Array  # stiffness [N m/rad] and damping [N m s/rad], shape (s, 2)


def parameters(supports: tuple[Support, ...], model: DiscreteModel) -> Parameters:
    """Matrices and directions of the supports; each is fixed to the hole where the unloaded string meets it."""
    node = model.nodes_at(np.array([support.distance_from_bit for support in supports]))
    x, y = transverse_axes(model.directions[node])

    def matrix(of: str) -> Array:
        x_y = [(getattr(each, of), getattr(each, f"{of}_y")) for each in supports]
        return np.array([[[along, getattr(each, f"{of}_xy")], [getattr(each, f"{of}_yx"), along if y is None else y]]
                         for each, (along, y) in zip(supports, x_y, strict=True)])  # fmt: skip

    tilt = np.array([[each.tilt_stiffness, each.tilt_damping] for each in supports])
    return Parameters(node, np.stack([x, y, model.centres[node]], axis=1), matrix("stiffness"), matrix("damping"), tilt)


@kernel
def node_load(
    parameters: Any, rod: Rod, time: float, half_step: float, u: Array, v: Array, v_old: Array, nodes: Array
) -> None:
    """Add K d + C d_dot across the hole, and the moment against tilt."""
    law = parameters.supports
    for k in range(law.node.shape[0]):
        i, frame = law.node[k], law.frame[k]
        out = nodes[i]
        for row in range(2):
            force, moment = 0.0, 0.0
            for col in range(2):
                spring, damper = law.spring[k, row, col], law.damper[k, row, col]
                slope = half_step * spring + damper
                off, speed, lean, turn = 0.0, 0.0, 0.0, 0.0
                for c in range(3):
                    off += frame[col, c] * (u[i, c] - frame[2, c])
                    speed += frame[col, c] * v[i, c]
                    lean += frame[col, c] * u[i, 3 + c]
                    turn += frame[col, c] * v[i, 3 + c]
                force += spring * off + damper * speed
                held = half_step * law.tilt[k, 0] + law.tilt[k, 1] if row == col else 0.0
                if row == col:
                    moment = law.tilt[k, 0] * lean + law.tilt[k, 1] * turn
                for a in range(3):
                    for b in range(3):
                        both = frame[row, a] * frame[col, b]
                        out[a, b] += slope * both
                        out[3 + a, 3 + b] += held * both
            for a in range(3):
                out[a, 7] += force * frame[row, a]
                out[3 + a, 7] += moment * frame[row, a]
