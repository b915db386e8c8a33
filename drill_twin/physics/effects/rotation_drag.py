# SPDX-License-Identifier: Apache-2.0
"""Viscous torque of the mud on the rotating string."""

from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.effects.mud import NO_ROTATION, ViscousEffect, hole_radius
from drill_twin.physics.model import DiscreteModel, Point, Rod


class RotationDrag(ViscousEffect):
    """Laminar Couette flow between string and hole: torque 4 pi mu omega r_o^2 R^2 / (R^2 - r_o^2) per length.

    Exact for a concentric string whose inner mud rotates with it (Bird, Stewart and Lightfoot 2002, example 3.6-3).
    Beyond omega^2 r_o (R - r_o)^3 = 1708 (mu / rho)^2 in a narrow gap (Taylor 1923) vortices increase it.
    """


class Parameters(NamedTuple):
    """Torque per length and spin rate [N s], shape (2 n,)."""

    rotary: Array


def parameters(block: RotationDrag, model: DiscreteModel) -> Parameters:
    """Compute the torque per length and spin rate at the Gauss points."""
    outer, hole = model.at_places(model.rod.outer_radius) ** 2, hole_radius(model) ** 2
    rotation = model.fastest_rotation or NO_ROTATION
    viscosity = model.fluid.apparent(2.0 * rotation * hole / (hole - outer))  # at the shear rate on the string
    return Parameters(4.0 * np.pi * viscosity * outer * hole / (hole - outer))


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the couple against the spin."""
    rotary = parameters.rotation_drag.rotary[here.place]
    load[3] -= rotary * here.spin_rate
    stiff[3, 3] += rotary
