# SPDX-License-Identifier: Apache-2.0
"""How deep the law of the wall lets a string sink in."""

from __future__ import annotations

import numpy as np

from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.twin import Twin

SAMPLES = 1000
"""Moments at which the schedule is asked for its largest load."""
NEIGHBOURS = 2.0
"""A bent string rests on parts of its contact only: the peak of its force per length over the mean of the helix."""


def deepest_allowed(twin: Twin, speed: float) -> float:
    """Depth at which a slice of the string comes to rest in the wall [m]; infinite where the scene lists no wall.

    From K d^(p+1) / (p+1) = m v^2 / 2 + q d for a slice of mass m per length that meets the wall at the speed v and is
    pressed by q per length, suddenly: by its weight, by what presses a helix on the wall, c P^2 / (4 EI) (Mitchell
    1988, c the clearance), and by six times the rms of a random force. Neighbours that press through the bending of
    the string count twice over.

    Args:
        twin: The string in its hole.
        speed: The largest lateral speed it had [m/s].
    """
    wall = twin.scene.effects.wall
    if wall is None:
        return np.inf
    power = 1.5 if wall.stiffness is not None else 1.0
    stiffness = float(wall.stiffness or wall.linear_stiffness)
    mass = float(twin.rod.line_mass.max())
    kinetic, pressed = 0.5 * mass * speed**2, NEIGHBOURS * pressure(twin)
    low, high = 0.0, 1e-9
    while stiffness * high ** (power + 1.0) / (power + 1.0) < kinetic + pressed * high:
        high *= 2.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        inside = stiffness * middle ** (power + 1.0) / (power + 1.0) < kinetic + pressed * middle
        low, high = (middle, high) if inside else (low, middle)
    return high


def pressure(twin: Twin) -> float:
    """Largest force per length that presses the string on the wall [N/m]."""
    scene, rod = twin.scene, twin.rod
    effects = scene.effects
    weight = effects.gravity.magnitude * float(rod.line_mass.max()) if effects.gravity is not None else 0.0
    clearance = float(twin.site.bore.clearance.max())
    helix = clearance * largest_load(scene) ** 2 / (4.0 * float(rod.bending.min()))
    random = 6.0 * effects.random_force.rms if effects.random_force is not None else 0.0
    return weight + helix + random


def largest_load(scene: Scene) -> float:
    """Largest weight on bit or pull of the schedule [N]."""
    schedule = Schedule.from_scene(scene)
    times = np.linspace(0.0, schedule.duration, SAMPLES)
    return max(abs(schedule.at(float(time)).weight_on_bit) for time in times)
