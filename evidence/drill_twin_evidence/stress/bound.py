# SPDX-License-Identifier: Apache-2.0
"""Bound on the penetration of the wall, from the contact law.

Tighter than the bound of the step guard (`drill_twin.dynamics.twin.binding`), and independent of it, so that each
finds an error in the other.
"""

from __future__ import annotations

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points import extremes

PEAK_FACTOR = 2.0
"""A bent string rests on parts of its contact only: peak over mean of its wall force per length."""


def allowed_depth(twin: Twin, speed: float) -> float:
    """Depth at which a slice of the string comes to rest in the wall [m]; infinite where the scene lists no wall.

    From K d^(p+1) / (p+1) = m v^2 / 2 + q d + h d^2 / 2 for a slice of mass m per length that meets the wall at the
    speed v and is pressed suddenly by q per length: by its weight, by six times the rms of a random force, and by the
    wall force of a helix, h (c + d) with h = P^2 / (4 EI) and c the clearance (Mitchell 1988). The
    uneven distribution along a bent string counts twice. A body at the bit meets the wall with half an element of
    string. A wall softer than h supports no helix: the string buckles into it as on an elastic foundation (Hetenyi
    1946, section 7), and only its length bounds the depth.

    Args:
        twin: The twin after its run.
        speed: Largest lateral speed of the run [m/s].
    """
    wall = twin.scene.effects.wall
    if wall is None:
        return np.inf
    power = 1.5 if wall.stiffness is not None else 1.0
    stiffness = float(wall.stiffness or wall.linear_stiffness)
    mass = max(float(twin.rod.line_mass.max()), line_mass_at_the_bit(twin)) + _of_discs(twin)[0]
    helix = extremes(twin.scene).weight_on_bit ** 2 / (4.0 * float(twin.rod.bending.min()))
    pressed = PEAK_FACTOR * (
        pressing_force(twin) + _of_discs(twin)[1] + helix * float(twin.model.wellbore.clearance.max())
    )

    def sinks_further(depth: float) -> bool:
        pushed = 0.5 * mass * speed**2 + pressed * depth + 0.5 * PEAK_FACTOR * helix * depth**2
        return bool(stiffness * depth ** (power + 1.0) / (power + 1.0) < pushed)

    low, high, longest = 0.0, 1e-9, float(twin.rod.arc[-1])
    while sinks_further(high):
        high *= 2.0
        if high > longest:
            return longest
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sinks_further(middle) else (low, middle)
    return high


def line_mass_at_the_bit(twin: Twin) -> float:
    """Mass per length of the last half element, with that of a body at the bit [kg/m]."""
    body = twin.scene.effects.bit_mass
    return float(twin.rod.line_mass[0]) + (body.mass / (0.5 * float(twin.rod.length[0])) if body is not None else 0.0)


def _of_discs(twin: Twin) -> tuple[float, float]:
    """Mass per length of the heaviest disc over half the elements beside it [kg/m], force of unbalance [N/m]."""
    arc, fastest = twin.rod.arc, extremes(twin.scene).rotation
    found = [(0.0, 0.0)]
    for disc in twin.scene.string.discs:
        node = int(np.abs(arc - disc.distance_from_bit).argmin())
        length = 0.5 * float(arc[min(node + 1, arc.size - 1)] - arc[max(node - 1, 0)])
        found.append((twin.scene.string.body_of(disc)[0] / length, disc.moment * fastest**2 / length))
    return max(mass for mass, _ in found), max(force for _, force in found)


def pressing_force(twin: Twin) -> float:
    """Largest external force per length that presses the string on the wall [N/m]: weight, random force."""
    effects = twin.scene.effects
    weight = effects.gravity.magnitude * float(twin.rod.line_mass.max()) if effects.gravity is not None else 0.0
    random = 6.0 * effects.random_force.rms if effects.random_force is not None else 0.0
    return weight + random
