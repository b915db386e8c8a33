# SPDX-License-Identifier: Apache-2.0
"""Rotary inertia and gyroscopic moments of discs and of the string's own cross-sections.

A body that is fixed to the tangent t = a / |a| (a = r') has the angular momentum Id t x t_dot + Ip psi_dot t. The
virtual turn of the tangent is t x dt, with dt = P da / |a| and P = 1 - t t, so the generalised force on a is

    -(1 / |a|) P [Id t_ddot + Ip psi_dot (t_dot x t)]

(Goldstein 1980, ch. 5; in small slopes the equations of Genta 2005, ch. 2). The second part is normal to a_dot and does
no work. The turn of the reference frame about the tangent, of the order of the slope squared, is left out of the spin,
as it is for the polar inertia of the sections.
"""

from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.model import DiscreteModel, Rod


class Gyroscopic(EffectConfig):
    """Rotary inertia and gyroscopic moments: of the discs of the string, and of its sections, lumped at the nodes."""

    across = True
    energy_class = "kept"


class Parameters(NamedTuple):
    """Polar and diametral inertia at the nodes [kg m2], shape (n + 1,) each."""

    polar: Array
    diametral: Array


def parameters(_block: Gyroscopic, model: DiscreteModel) -> Parameters:
    """Lump half the inertia of an element, Ip = 2 Id per length, at each of its ends; add the discs."""
    polar = 0.5 * (np.append(model.rod.spin_mass, 0.0) + np.append(0.0, model.rod.spin_mass))
    diametral = 0.5 * polar
    if model.bodies is not None:
        np.add.at(polar, model.bodies.node, model.bodies.polar)
        np.add.at(diametral, model.bodies.node, model.bodies.diametral)
    return Parameters(polar, diametral)


@kernel
def node_load(
    parameters: Any, rod: Rod, time: float, half_step: float, u: Array, v: Array, v_old: Array, nodes: Array
) -> None:
    """Add (Id P w + Ip psi_dot a_dot x t) / |a|^2 with w = a_ddot - 2 s a_dot and s = t . a_dot / |a|."""
    law, rate = parameters.gyroscopic, 1.0 / half_step
    for i in range(nodes.shape[0]):
        out, spin = nodes[i], v[i, 6]
        square = u[i, 3] * u[i, 3] + u[i, 4] * u[i, 4] + u[i, 5] * u[i, 5]
        size = np.sqrt(square)
        own, gyro = law.diametral[i] / square, law.polar[i] / square
        t = (u[i, 3] / size, u[i, 4] / size, u[i, 5] / size)
        d = (v[i, 3], v[i, 4], v[i, 5])
        s = (t[0] * d[0] + t[1] * d[1] + t[2] * d[2]) / size
        w = (
            rate * (d[0] - v_old[i, 3]) - 2.0 * s * d[0],
            rate * (d[1] - v_old[i, 4]) - 2.0 * s * d[1],
            rate * (d[2] - v_old[i, 5]) - 2.0 * s * d[2],
        )
        on = t[0] * w[0] + t[1] * w[1] + t[2] * w[2]
        cross = (d[1] * t[2] - d[2] * t[1], d[2] * t[0] - d[0] * t[2], d[0] * t[1] - d[1] * t[0])
        for r in range(3):
            # part of a_dot normal to t, and the residual of a
            normal, force = d[r] - s * size * t[r], own * (w[r] - on * t[r]) + gyro * spin * cross[r]
            out[3 + r, 7] += force
            out[3 + r, 6] += gyro * cross[r]
            for c in range(3):
                p = (1.0 if r == c else 0.0) - t[r] * t[c]
                pw = w[c] - on * t[c]
                # e_c x t and a_dot x P e_c
                turn, moved = 0.0, 0.0
                if r != c:
                    other = 3 - r - c
                    sign = 1.0 if (c - r) % 3 == 1 else -1.0
                    # (e_c x t)_r = eps(r, c, other) t_other
                    turn = sign * t[other]
                one, two = (r + 1) % 3, (r + 2) % 3
                p_one = (1.0 if one == c else 0.0) - t[one] * t[c]
                p_two = (1.0 if two == c else 0.0) - t[two] * t[c]
                moved = d[one] * p_two - d[two] * p_one
                by_v = own * ((rate - 2.0 * s) * p - 2.0 * normal * t[c] / size) + gyro * spin * turn
                by_a = (
                    own * (-2.0 * normal * (d[c] - 2.0 * s * size * t[c]) / square - (on * p + t[r] * pw) / size)
                    + (gyro * spin * moved - 2.0 * force * t[c]) / size
                )
                out[3 + r, 3 + c] += by_v + half_step * by_a
