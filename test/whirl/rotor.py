# SPDX-License-Identifier: Apache-2.0
"""One mode of a buckling, spinning string in a hole: motion that nobody prescribed, for tests of the analysis.

m z'' + (c_e + c_i) z' + (k(t) - i c_i Omega) z + k_3 |z|^2 z = imbalance + wall (Jeffcott rotor with rotating damping,
Genta 2005). The weight on bit ramps up and takes the stiffness k below zero; internal damping then turns the buckled
shape forward at c_i / (c_i + c_e) of the rotation, and friction at the wall slows it or rolls it backward.
"""

import math
from dataclasses import dataclass

import numpy as np
from kinematics import BENCH, TURN, Motion, turning


@dataclass(frozen=True)
class Rotor:
    mass: float = 1.0
    external: float = 1.0  # c_e
    internal: float = 1.0  # c_i
    frequency: float = 1.0  # [Hz] unloaded
    overload: float = 1.3  # k falls to (1 - overload) k
    ramp: tuple = (2.0, 8.0)  # [s] of the load
    limit: float = 0.9  # radius of the buckled shape over the clearance, without the wall
    eccentricity: float = 2e-4  # [m]
    friction: float = 0.0
    start: complex = 1e-5 + 0j  # [m]
    speed: float = 2.0  # [rev/s]


def whirl_of(rotor, seconds=20.0, rate=200.0, step=2.5e-4, mark=BENCH):
    """The motion of a rotor, its steady response to the imbalance as `rest`, and the force of the wall."""
    k0 = rotor.mass * (TURN * rotor.frequency) ** 2
    cubic = (rotor.overload - 1.0) * k0 / (rotor.limit * mark.clearance) ** 2
    stiff = 4e4 * rotor.mass
    n = round(seconds / step)
    time = np.arange(n + 1) * step
    angle, speed = turning(time, rotor.speed)
    begin, end = rotor.ramp
    x = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    load = (1.0 - rotor.overload * x * x * (3 - 2 * x)) * k0
    force = rotor.mass * rotor.eccentricity * speed**2 * np.exp(1j * angle)
    z, v = rotor.start, 0j
    path, pushes = np.empty(n + 1, complex), np.empty(n + 1)
    damping = rotor.external + rotor.internal
    for i, (k, w, f) in enumerate(zip(load.tolist(), speed.tolist(), force.tolist(), strict=True)):
        size = abs(z)
        depth = size - mark.clearance
        push = 0.0
        a = f - (k - 1j * rotor.internal * w + cubic * size * size) * z - damping * v
        if depth > 0.0:
            out = z / size
            radial = (v * out.conjugate()).real
            push = max(0.0, stiff * depth + 40.0 * radial)
            slip = (v * out.conjugate()).imag + w * mark.wall_offset
            a -= push * out + rotor.friction * push * 1j * out * math.tanh(slip / 0.01)
        path[i], pushes[i] = z, push
        v += step * a / rotor.mass
        z += step * v
    every = round(1.0 / (rate * step))
    pick = slice(None, None, every)
    turn = np.exp(1j * angle)
    # Steady response to the imbalance; internal damping drops out of it (Genta 2005).
    bow = (
        rotor.mass * rotor.eccentricity * speed**2 / (load - rotor.mass * speed**2 + 1j * rotor.external * speed) * turn
    )
    rest = bow[pick][:, None]
    return Motion(
        (mark,),
        time[pick],
        angle[pick][:, None],
        speed[pick],
        path[pick][:, None] - rest,
        rest,
        np.zeros_like(rest),
        pushes[pick][:, None],
    )
