# SPDX-License-Identifier: Apache-2.0
"""Motion of a torsional rig by a time stepper of its own: it has nothing of the package's kernels.

A drive with a controller of its speed, a string of one or more springs with the inertia between them lumped at their
joints, and a bit in friction. Semi-implicit Euler at a quarter of a millisecond; a bit in the zone of sticking is held
while friction can hold it (Karnopp 1985), but for the law of tanh, which knows no rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from drill_twin.core.arrays import Array

STEP = 0.25e-3
"""Time step [s]."""
EXPONENTIAL, GAUSSIAN, KARNOPP, JOINED, TANH = range(5)
"""Laws of friction by their fall from sticking to sliding torque."""


class Mechanics(NamedTuple):
    """Numbers of a rig in SI units.

    Attributes:
        law: Law of friction at the bit.
        sticking: Torque that breaks the bit off [N m].
        sliding: Torque at high speed [N m].
        decay: Inverse of the speed over which friction falls [s/rad].
        zone: Speed below which the bit sticks, or of the tanh [rad/s].
        bit_inertia: [kg m^2].
        bit_damping: [N m s/rad].
        stiffness: Of the whole string in torsion [N m/rad].
        string_damping: Of the whole string [N m s/rad].
        string_inertia: [kg m^2].
        springs: Number of springs of the string.
        drive_inertia: [kg m^2].
        drive_damping: [N m s/rad].
        proportional: Motor torque per error of speed [N m s/rad].
        integral: Motor torque per error of angle [N m/rad].
        lag: Time constant with which the motor torque follows its controller [s]; 0 s: at once.
        speed: Commanded speed [rad/s], reached by a straight line over `ramp`.
        ramp: [s].
    """

    law: int
    sticking: float
    sliding: float
    decay: float
    zone: float
    bit_inertia: float = 471.9698
    bit_damping: float = 50.0
    stiffness: float = 861.5336
    string_damping: float = 172.3067
    string_inertia: float = 0.0
    springs: int = 1
    drive_inertia: float = 2122.0
    drive_damping: float = 425.0
    proportional: float = 8000.0
    integral: float = 3000.0
    lag: float = 0.0
    speed: float = 2.5
    ramp: float = 4.0


@njit(cache=True)
def friction(rig: Mechanics, speed: float) -> float:
    """Size of the torque of friction of a bit that slips [N m]."""
    u = abs(speed) * rig.decay
    more = rig.sticking - rig.sliding
    if rig.law == GAUSSIAN:
        return rig.sliding + more * math.exp(-u * u)
    if rig.law == KARNOPP:
        return rig.sliding
    if rig.law == JOINED:
        return rig.sliding + more * min(1.0, max(0.0, (2.0 - u) / 1.7))
    return rig.sliding + more * math.exp(-u)


@njit(cache=True)
def motion(rig: Mechanics, steps: int, time_step: float = STEP) -> Array:
    """Torque of drive on string [N m], speed of drive, speed of bit [rad/s], friction [N m] after each step, (T, 4)."""
    n = rig.springs + 1
    angle, speed = np.zeros(n), np.zeros(n)
    inertia = np.full(n, rig.string_inertia / n)
    inertia[0] += rig.drive_inertia
    inertia[-1] += rig.bit_inertia
    stiffness, damping = rig.stiffness * rig.springs, rig.string_damping * rig.springs
    links = np.zeros(n - 1)
    lagging = motor = 0.0
    found = np.zeros((steps, 4))
    for step in range(steps):
        for i in range(n - 1):
            links[i] = stiffness * (angle[i] - angle[i + 1]) + damping * (speed[i] - speed[i + 1])
        wanted = rig.speed * min(1.0, step * time_step / rig.ramp)
        error = wanted - speed[0]
        lagging += error * time_step
        asked = rig.proportional * error + rig.integral * lagging
        motor = asked if rig.lag == 0.0 else motor + (asked - motor) * time_step / rig.lag
        speed[0] += time_step * (motor - rig.drive_damping * speed[0] - links[0]) / inertia[0]
        for i in range(1, n - 1):
            speed[i] += time_step * (links[i - 1] - links[i]) / inertia[i]
        driving = links[-1] - rig.bit_damping * speed[-1]
        if rig.law == TANH:
            held = friction(rig, speed[-1]) * math.tanh(speed[-1] / rig.zone)
            speed[-1] += time_step * (driving - held) / inertia[-1]
        elif abs(speed[-1]) < rig.zone and abs(driving) < rig.sticking:
            held, speed[-1] = driving, 0.0
        else:
            way = np.sign(speed[-1]) if abs(speed[-1]) >= rig.zone else np.sign(driving)
            held = way * friction(rig, speed[-1])
            speed[-1] += time_step * (driving - held) / inertia[-1]
        angle += time_step * speed
        found[step] = links[0], speed[0], speed[-1], held
    return found
