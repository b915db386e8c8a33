# SPDX-License-Identifier: Apache-2.0
"""Viscous drag of the mud on lateral motion, without flow separation."""

from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.effects.mud import ViscousEffect, add_across, lateral_force, resist_across
from drill_twin.physics.model import DiscreteModel, Point, Rod


class ViscousDrag(ViscousEffect):
    """Drag c v per length on the velocity across the string, of mud that a small motion shears in a concentric hole.

    c = -rho pi r_o^2 omega Im(H), H after Chen, Wambsganss and Jendrzejczyk (1976), at the frequency of `mud`: the
    fastest rotation of the set-points. Vortices add the effect `quadratic_drag` (Bearman and others 1985). Not in the
    model: mud that turns with the string, and a string beside the axis of the hole.
    """

    across = True


class Parameters(NamedTuple):
    """Force per length and velocity [N s/m2], shape (2 n,)."""

    lateral: Array


def parameters(block: ViscousDrag, model: DiscreteModel) -> Parameters:
    """Compute the force per length and velocity at the Gauss points."""
    displaced = model.fluid_density * np.pi * model.at_places(model.rod.outer_radius) ** 2
    return Parameters(displaced * lateral_force(model).drag)


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the force -c (1 - t t) v."""
    c = parameters.viscous_drag.lateral[here.place]
    resist_across(here, c, here.vx, here.vy, here.vz, load)
    add_across(here, c, stiff)
