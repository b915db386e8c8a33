# SPDX-License-Identifier: Apache-2.0
"""Plausibility of a state: one compiled pass over the nodes, and a verdict in numbers for Python to word."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel

# Indices into the extremes: node that is not finite (-1: none), largest speed of the string's surface [m/s] and its
# node, largest absolute strain [-] and its node, largest inclination 1 - t_z of a tangent (0: along z, 2: folded back)
# and its node.
BROKEN, SPEED, SPEED_AT, STRAIN, STRAIN_AT, LEAN, LEAN_AT = range(7)
EXTREMES = 7
LARGEST = 1e300

PLAUSIBLE, NOT_FINITE, TOO_FAST, LEANING, STRAINED, TOO_DEEP = range(6)
"""Kinds of verdict."""
KIND, NODE, FOUND, ALLOWED = range(4)
"""Indices into a verdict: its kind, the node at which it is largest, what was found and what is allowed."""
VERDICT = 4

DEPTH_MARGIN = 10.0
"""Largest plausible penetration over the penetration by the contact law at the current speed and load."""


class Bounds(NamedTuple):
    """Bounds of a plausible state, and what the largest penetration follows from."""

    speed: float  # largest: the speed of sound in the string, at least `LEAST_SPEED` [m/s]
    tilt: float  # largest 1 - t_z
    strain: float  # largest in size; infinite in the lateral formulation
    lateral: bool
    walled: bool
    stiffness: float  # of the wall, and the power of its law
    power: float
    line_mass: float  # largest mass per length, mud included [kg/m]
    flexibility: float  # largest clearance over 4 EI [1/(N m)]: times the load squared, wall force of a helix [N/m]
    weight: float  # of the string [N]
    line_load: float  # largest weight per length, and six times the rms of a random force [N/m]
    curvature: float  # largest of the hole [1/m]


@kernel
def static_depth(bounds: Bounds, load: float) -> float:
    """Penetration at rest under a load [N], of a helix pressed on the wall over its whole length [m].

    Its force is F^2 r / (4 EI) (Lubinski, Althouse and Logan 1962), with weight, random force and curvature.
    """
    axial = abs(load) + bounds.weight
    pressed = axial**2 * bounds.flexibility + axial * bounds.curvature + bounds.line_load
    return (pressed / bounds.stiffness) ** (1.0 / bounds.power)  # type: ignore[no-any-return]


@kernel
def largest_depth(bounds: Bounds, speed: float, load: float, step: float) -> float:
    """Largest plausible penetration into the wall [m].

    `DEPTH_MARGIN` times the sum of two depths: of an impact, K d^(p+1) / (p+1) = m v^2 / 2 per length, and under the
    load; plus the distance moved in a step, as contact is evaluated at the ends of a step only.

    Args:
        bounds: Bounds of the scene.
        speed: Largest speed of the string [m/s].
        load: Weight on bit [N].
        step: Time step [s].
    """
    power = bounds.power
    impact = (0.5 * (power + 1.0) * bounds.line_mass * speed**2 / bounds.stiffness) ** (1.0 / (power + 1.0))
    return DEPTH_MARGIN * (impact + static_depth(bounds, load)) + speed * step  # type: ignore[no-any-return]


@kernel
def find_extremes(radius: Array, u: Array, v: Array, out: Array) -> None:
    """Fill `out`, shape (7,), from node rows u, v (r, r', psi), shape (n + 1, 7) each.

    Args:
        radius: Outer radius of the elements [m], shape (n,).
        u: Node rows.
        v: Their velocities.
        out: Takes the extremes.
    """
    for k in range(EXTREMES):
        out[k] = 0.0
    out[BROKEN] = -1.0
    last = u.shape[0] - 1
    for i in range(last + 1):
        total = 0.0
        for c in range(7):
            total += abs(u[i, c]) + abs(v[i, c])
        if not total <= LARGEST:  # not np.isfinite, which computes x - x: of a sum, reassociated, that is 0
            out[BROKEN] = i
            return
        turn = radius[min(i, last - 1)] * v[i, 6]
        speed = np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2 + turn * turn)
        g = np.sqrt(u[i, 3] ** 2 + u[i, 4] ** 2 + u[i, 5] ** 2)
        strain = abs(g - 1.0)
        lean = 1.0 - u[i, 5] / max(g, 1e-12)
        if speed > out[SPEED]:
            out[SPEED], out[SPEED_AT] = speed, i
        if strain > out[STRAIN]:
            out[STRAIN], out[STRAIN_AT] = strain, i
        if lean > out[LEAN]:
            out[LEAN], out[LEAN_AT] = lean, i


@kernel
def judge(bounds: Bounds, now: Array, before: Array, deepest: Array, load: float, step: float, verdict: Array) -> bool:
    """Judge a state by its extremes; returns whether a bound is exceeded, and fills the verdict.

    Args:
        bounds: Bounds of the scene.
        now: Extremes of the state.
        before: Extremes at the start of the frame.
        deepest: Largest penetration into the wall [m], and its Gauss point.
        load: Weight on bit, the larger of the two at start and end of the frame [N].
        step: Time step [s].
        verdict: Takes the verdict, see `KIND`.
    """
    depth, place = deepest[0], deepest[1]
    kind, node, found, allowed = PLAUSIBLE, 0.0, 0.0, 0.0
    if now[BROKEN] >= 0.0:
        kind, node = NOT_FINITE, now[BROKEN]
    elif now[SPEED] > bounds.speed:
        kind, node, found, allowed = TOO_FAST, now[SPEED_AT], now[SPEED], bounds.speed
    elif now[LEAN] > bounds.tilt:
        kind, node, found, allowed = LEANING, now[LEAN_AT], now[LEAN], bounds.tilt
    elif now[STRAIN] > bounds.strain:
        kind, node, found, allowed = STRAINED, now[STRAIN_AT], now[STRAIN], bounds.strain
    elif bounds.walled and depth > 0.0:
        allowed = largest_depth(bounds, max(before[SPEED], now[SPEED]), load, step)
        if depth > allowed:
            kind, node, found = TOO_DEEP, (place + 1.0) // 2.0, depth
    verdict[KIND], verdict[NODE], verdict[FOUND], verdict[ALLOWED] = kind, node, found, allowed
    return kind != PLAUSIBLE
