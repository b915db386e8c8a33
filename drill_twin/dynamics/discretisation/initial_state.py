# SPDX-License-Identifier: Apache-2.0
"""Initial state: the string on the axis of the hole, at rest, untwisted and in axial equilibrium."""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.audit.energy import element_unknowns
from drill_twin.dynamics.discretisation.discretise import axis_at
from drill_twin.dynamics.solver.state import State
from drill_twin.physics.effects.gravity import line_weight
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.physics.model.mesh import SPIN, Rod
from drill_twin.scene import Scene


def axial_weight(scene: Scene, model: DiscreteModel) -> Array:
    """Weight of each element along the hole [N], shape (n,)."""
    rod, gravity = model.rod, scene.effects.gravity
    if gravity is None:
        return np.zeros(rod.length.size)
    axis = axis_at(scene, rod.arc[-1] - 0.5 * (rod.arc[1:] + rod.arc[:-1]))
    up = np.array([-np.sin(model.inclination), 0.0, np.cos(model.inclination)])
    share = up[2] if axis is None else axis.tangent @ up
    return np.asarray(line_weight(gravity, model) * rod.length * share)


def set_initial_state(state: State, model: DiscreteModel, scene: Scene, weight_on_bit: float) -> None:
    """Set the string on the hole's axis, stretched by weight and load, so that no axial waves start at t = 0."""
    rod, weight = model.rod, axial_weight(scene, model)
    below = np.concatenate([[0.0], np.cumsum(weight)])
    tension = below - weight_on_bit
    if scene.rig.weight_on_bit.at == "top":
        tension = below - below[-1] - weight_on_bit
    strain, elongation = _balanced(rod, tension, weight)
    stretch = np.cumsum(elongation)
    along = rod.arc - rod.arc[-1] + np.concatenate([[0.0], stretch]) - stretch[-1]
    slope = 1.0 + strain
    axis = axis_at(scene, -along)
    if axis is None:
        state.u[:, 2], state.u[:, 5] = along, slope
        return
    state.u[:, 0:3], state.u[:, 3:6] = axis.centre, slope[:, None] * axis.tangent
    state.u[:, SPIN] = untwisted(rod, state.u)


def _balanced(rod: Rod, tension: Array, weight: Array) -> tuple[Array, Array]:
    """Strain at the nodes and elongation of the elements [m] for which the samples of stretch are in balance.

    In the elements at a change of section these are not those of the continuous string, whose strain jumps there.

    Args:
        rod: The string.
        tension: At the nodes [N], shape (n + 1,).
        weight: Axial weight of the elements [N], shape (n,).
    """
    middle = 0.5 * (tension[1:] + tension[:-1])
    lower, upper, twelfth = rod.samples[:-1, 1], rod.samples[1:, 0], weight * rod.length / 12.0
    shared = lower * middle[:-1] + upper * middle[1:] + twelfth[:-1] - twelfth[1:]
    shared /= lower * rod.axial[:-1] + upper * rod.axial[1:]
    strain = tension / np.append(rod.axial, rod.axial[-1])
    strain[1:-1] = np.where(np.diff(rod.axial) != 0.0, shared, strain[1:-1])
    elongation = middle / rod.axial * rod.length
    elongation -= 0.5 * np.diff(tension) / rod.axial * (rod.samples[:, 0] - rod.samples[:, 1])
    for end, at in ((0, slice(None, -1)), (1, slice(1, None))):
        elongation += rod.samples[:, end] * (strain[at] - tension[at] / rod.axial)
    return strain, elongation


def untwisted(rod: Rod, u: Array) -> Array:
    """Spin at the nodes with zero mean twist in each element, 0 at the top [rad], shape (n + 1,).

    Twist is psi' + A, with A the twist of the reference frame (`drill_twin.physics.model.strain`).
    """
    nodal = element_unknowns(u)
    a, b = (np.einsum("epi,eic->epc", rod.shape[:, :, order], nodal) for order in (1, 2))
    g = np.linalg.norm(a, axis=-1)
    reference = -(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) / (g * (g + a[..., 2]))
    climb = -reference.mean(axis=1) * rod.length
    spin: Array = np.concatenate([[0.0], np.cumsum(climb)]) - climb.sum()
    return spin
