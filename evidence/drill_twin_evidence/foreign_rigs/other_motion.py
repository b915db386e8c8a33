# SPDX-License-Identifier: Apache-2.0
"""Motion of rigs whose string, drive, sensors and rock differ from our scene in more than a law of friction.

A drive, a string of lumped springs and a bit, by semi-implicit Euler at a quarter of a millisecond. The bit is held at
rest while friction can hold it. Nothing of the package's kernels is used.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from drill_twin.core.arrays import Array

STEP = 0.25e-3
"""Time step [s]."""
EXPONENTIAL, HYPERBOLIC, LUGRE, DEPTH_OF_CUT = range(4)
"""Laws of the torque at the bit."""
_REST = 1e-3  # rad/s, below which the bit may be held


class Machine(NamedTuple):
    """Numbers of a rig in SI units.

    Attributes:
        law: Law of the torque at the bit.
        sticking: Torque that breaks the bit off [N m].
        sliding: Torque at high speed [N m].
        decay: Inverse of the speed over which friction falls [s/rad].
        viscous: Growth of the torque with speed, of a law that strengthens [N m s/rad].
        patches: Relative size of a variation of the torque with the angle of the bit, three times a revolution.
        wander: Relative standard deviation of the torque by rock that changes along the hole; memory of 10 s.
        change: Relative change of both frictions at `change_time`.
        change_time: [s].
        bit_inertia: [kg m^2].
        bit_damping: [N m s/rad].
        stiffness: Of the whole string [N m/rad].
        string_damping: Of the whole string [N m s/rad].
        string_inertia: [kg m^2].
        springs: Number of springs.
        drag: Torque of mud on the string over the square of its speed [N m s^2/rad^2].
        wall: Torque of dry friction on the string [N m].
        play: Backlash above the bit [rad].
        drive_inertia: [kg m^2].
        proportional: Motor torque per error of speed [N m s/rad].
        integral: Motor torque per error of angle [N m/rad].
        drive_damping: [N m s/rad].
        lag: Time constant of the motor torque [s].
        droop: Share of the speed that the set-point falls by for each 10 kN m of motor torque.
        power: Largest power of the motor [W]; 0 W: none.
        speed: Commanded speed [rad/s], reached by a straight line over 4 s.
        weight: Weight on bit [N].
    """

    law: int = EXPONENTIAL
    sticking: float = 6000.0
    sliding: float = 3400.0
    decay: float = 1.0
    viscous: float = 0.0
    patches: float = 0.0
    wander: float = 0.0
    change: float = 0.0
    change_time: float = 1e9
    bit_inertia: float = 471.9698
    bit_damping: float = 50.0
    stiffness: float = 861.5336
    string_damping: float = 172.3067
    string_inertia: float = 0.0
    springs: int = 1
    drag: float = 0.0
    wall: float = 0.0
    play: float = 0.0
    drive_inertia: float = 2122.0
    proportional: float = 8000.0
    integral: float = 3000.0
    drive_damping: float = 425.0
    lag: float = 0.0
    droop: float = 0.0
    power: float = 0.0
    speed: float = 2.5
    weight: float = 55e3


@njit(cache=True)
def motion(rig: Machine, steps: int, rock: Array) -> Array:
    """Torque of drive on string [N m], speed of drive, speed of bit [rad/s], torque at the bit after each step, (T, 4).

    Args:
        rig: The rig.
        steps: Number of steps, T.
        rock: Factor of the torque at the bit at each step, shape (T,).
    """
    dt = STEP
    n = rig.springs + 1
    angle, speed = np.zeros(n), np.zeros(n)
    inertia = np.full(n, rig.string_inertia / n)
    inertia[0] += rig.drive_inertia
    inertia[-1] += rig.bit_inertia
    stiffness, damping = rig.stiffness * rig.springs, rig.string_damping * rig.springs
    links = np.zeros(n - 1)
    lagging = motor = bristle = 0.0
    # Regenerative bit: six blades of 60 MPa, mass on an axial damper, after Richard, Germay and Detournay 2007.
    blades, specific, radius, mass = 6, 60e6, 0.311, 34e3
    depth, fall, back, wear = 0.0, 0.0, 0, 0.5 * rig.weight
    depths, turned = np.zeros(steps + 1), np.zeros(steps + 1)
    found = np.zeros((steps, 4))
    for step in range(steps):
        time = step * dt
        for i in range(n - 1):
            twist = angle[i] - angle[i + 1]
            if i == n - 2 and rig.play > 0.0:
                free = 0.5 * rig.play
                twist = twist - free if twist > free else (twist + free if twist < -free else 0.0)
            touching = 1.0 if twist != 0.0 or rig.play == 0.0 or i < n - 2 else 0.0
            links[i] = stiffness * twist + touching * damping * (speed[i] - speed[i + 1])
        wanted = rig.speed * min(1.0, time / 4.0) * (1.0 - rig.droop * motor / 1e4)
        error = wanted - speed[0]
        lagging += error * dt
        asked = rig.proportional * error + rig.integral * lagging
        if rig.power > 0.0:
            most = rig.power / max(abs(speed[0]), 0.5)
            if abs(asked) > most:
                lagging -= error * dt
                asked = math.copysign(most, asked)
        motor = asked if rig.lag == 0.0 else motor + (asked - motor) * dt / rig.lag
        speed[0] += dt * (motor - rig.drive_damping * speed[0] - links[0]) / inertia[0]
        for i in range(1, n - 1):
            drag = (rig.drag * abs(speed[i]) * speed[i] + rig.wall * math.tanh(speed[i] / 0.05)) / (n - 2)
            speed[i] += dt * (links[i - 1] - links[i] - drag) / inertia[i]
        size = rock[step] * (1.0 + rig.patches * math.cos(3.0 * angle[-1]))
        if time >= rig.change_time:
            size *= 1.0 + rig.change
        driving = links[-1] - rig.bit_damping * speed[-1]
        v = speed[-1]
        if rig.law == LUGRE:
            stiff, loss = 1e5, 300.0
            level = rig.sliding + (rig.sticking - rig.sliding) * math.exp(-((v * rig.decay) ** 2))
            change = v - abs(v) * stiff * bristle / (size * level)
            bristle += dt * change
            held = stiff * bristle + loss * change + rig.viscous * v
            speed[-1] += dt * (driving - held) / inertia[-1]
        else:
            if rig.law == DEPTH_OF_CUT:
                while back < step and turned[back + 1] <= turned[step] - 2.0 * math.pi / blades:
                    back += 1
                cut = max(0.0, depths[step] - (depths[back] if turned[step] > 2.0 * math.pi / blades else 0.0))
                force = blades * specific * radius * cut
                push = rig.weight - force - 2e4 * fall
                held_up = wear if fall > 0.0 else (0.0 if fall < 0.0 else min(max(push, 0.0), wear))
                after = fall + dt * (push - held_up) / mass
                fall = 0.0 if after * fall < 0.0 or v <= _REST else after
                most = size * (0.5 * 0.5 * radius * held_up + 0.4 * radius * force)
                most_at_rest = most
            else:
                u = abs(v) * rig.decay
                shape = 1.0 / (1.0 + u) if rig.law == HYPERBOLIC else math.exp(-u)
                most = size * (rig.sliding + (rig.sticking - rig.sliding) * shape + rig.viscous * abs(v))
                most_at_rest = size * rig.sticking
            if abs(v) < _REST and abs(driving) < most_at_rest:
                held, speed[-1] = driving, 0.0
            else:
                way = math.copysign(1.0, v) if abs(v) >= _REST else math.copysign(1.0, driving)
                held = way * most
                speed[-1] += dt * (driving - held) / inertia[-1]
        angle += dt * speed
        depth += dt * fall
        depths[step + 1], turned[step + 1] = depth, max(turned[step], angle[-1])
        found[step] = links[0], speed[0], speed[-1], held
    return found
