# SPDX-License-Identifier: Apache-2.0
"""The rod of a scene in plain numbers, as every tool needs it, and the law of the wall that all share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit

from drill_twin.physics.effects.wall import damping_number
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.benchmarks.peers.task import SCENES, Array, Task


@dataclass(frozen=True)
class Rod:
    """A uniform rod along z, its bottom at -length and its clamp at 0, and what acts on it; all SI."""

    length: float
    radius: float
    youngs_modulus: float
    shear_modulus: float
    density: float
    gravity: float
    drag: float
    """Force per length and velocity [N s/m^2]."""
    kick: float
    """Velocity of mid-span in x at time zero [m/s]; sin^2 along the rod."""
    hole: float
    """Radius of the hole [m]."""
    law: Array | None
    """Of the wall, for `wall_force`; None without one."""
    weight_on_bit: Callable[[float], float]
    """Time [s] -> upward force on the bottom [N]."""
    rotation: Callable[[float], float]
    """Time [s] -> speed of the top [rad/s]."""
    duration: float
    frames: int

    @property
    def area(self) -> float:
        """Cross-section [m^2]."""
        return float(np.pi * self.radius**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area for bending [m^4]."""
        return float(np.pi / 4.0 * self.radius**4)

    @property
    def line_mass(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * self.area

    def kick_at(self, above_bottom: Array) -> tuple[Array, Array]:
        """Velocity in x [m/s] and its derivative along the rod [1/s] at time zero."""
        s = np.pi * np.clip(above_bottom / self.length, 0.0, 1.0)
        return self.kick * np.sin(s) ** 2, self.kick * np.pi / self.length * np.sin(2.0 * s)

    def staggered(self, n: int, plain: bool) -> tuple[float, float]:
        """Length of an edge of a rod of n straight edges, and how far it reaches beyond each clamp [m].

        It bends only between the middles of its first and last edge, so these stand where the rod is clamped; `plain`:
        as the tool comes, its ends at the clamps.
        """
        return (self.length / n, 0.0) if plain else (self.length / (n - 1), 0.5 * self.length / (n - 1))

    def hung(self, above_bottom: Array) -> tuple[Array, Array]:
        """Axial displacement [m] and strain [-] of the rod that hangs at rest."""
        x = np.clip(above_bottom, 0.0, self.length)
        strain = self.density * self.gravity / self.youngs_modulus
        return -0.5 * strain * (self.length**2 - x**2), strain * x


def scene_of(task: Task) -> Scene:
    """The scene of a task, one of benchmarks/scenes or an installed one; its options are overrides too."""
    numerics = {"numerics.elements": str(task.elements)}
    if task.step:
        numerics["numerics.step"] = f"{task.step!r} s"
    return load_scene(_file(task), overrides={**task.changes, **numerics, **task.options})


def _file(task: Task) -> Path | str:
    own = SCENES / f"{task.scene}.yaml"
    return own if own.is_file() else task.scene


def rod_of(task: Task) -> Rod:
    """The rod of a task. Effects that no peer has are not looked at: see `benchmarks/scenes`."""
    scene = load_scene(_file(task), overrides=dict(task.changes))
    section, effects, schedule = scene.string.sections[0], scene.effects, Schedule.from_scene(scene)
    radius = 0.5 * section.outer_diameter
    law = None
    if effects.wall is not None:
        friction = effects.wall_friction
        law = np.array(
            [
                scene.hole.radius_at(0.0) - radius,
                effects.wall.stiffness,
                damping_number(effects.wall.restitution) / effects.wall.reference_speed,
                friction.coefficient if friction else 0.0,
                friction.decay if friction else 0.0,
                np.pi / (2.0 * friction.accuracy) if friction else 1.0,
                radius,
                np.inf,
            ]
        )
    return Rod(
        length=section.length,
        radius=radius,
        youngs_modulus=section.youngs_modulus,
        shear_modulus=section.shear_modulus,
        density=section.density,
        gravity=effects.gravity.magnitude if effects.gravity else 0.0,
        drag=effects.drag.linear if effects.drag else 0.0,
        kick=effects.lateral_kick.velocity if effects.lateral_kick else 0.0,
        hole=scene.hole.radius_at(0.0),
        law=law,
        weight_on_bit=schedule.weight_on_bit,
        rotation=schedule.rotation,
        duration=schedule.duration,
        frames=round(schedule.duration * scene.numerics.frame_rate),
    )


@njit(cache=True, error_model="numpy")
def wall_force(
    law: Array, x: float, y: float, vx: float, vy: float, vz: float, spin: float
) -> tuple[float, float, float, float]:
    """Force [N/m] and torque about the axis [N] of the wall per metre of rod, for tools that take our word for it.

    The same law as `drill_twin.physics.effects.wall` and `wall_friction`: K d^1.5 (1 + chi d_dot), not negative, and
    friction mu N s / sqrt(s^2 + creep^2) / (1 + delta s) against the slip of the contact point, spin and axial sliding
    included. The last number of the law bounds the slope of friction by slip [N s/m^2], for explicit steps.
    """
    clearance, stiffness, chi, mu, delta, creep, lever, steepest = law
    radius = np.sqrt(x * x + y * y)
    if radius <= clearance:
        return 0.0, 0.0, 0.0, 0.0
    nx, ny = x / radius, y / radius
    depth = radius - clearance
    press = stiffness * depth**1.5 * max(1.0 + chi * (nx * vx + ny * vy), 0.0)
    around = -ny * vx + nx * vy + lever * spin
    slip = np.sqrt(around * around + vz * vz)
    size = np.sqrt(slip * slip + creep * creep)
    rub = -min(mu * press / (1.0 + delta * slip) / size, steepest)
    return -press * nx - rub * around * ny, -press * ny + rub * around * nx, rub * vz, lever * rub * around
