# SPDX-License-Identifier: Apache-2.0
"""Run of a scene that returns scalar results for comparison: onset, whirl, radius, contact, cost."""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass

import numpy as np

from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.twin.twin import Twin
from drill_twin.whirl import Analyzer

PERTURBATION = 1e-4
"""Size of the random velocity by which replicas of a run differ [m/s]; far below the speed of whirl."""
WAVES = 5
"""Number of half waves along the string in the random velocity."""


@dataclass(frozen=True)
class Trial:
    """Scalar results of a run."""

    onset_s: float | None
    """Onset of whirl [s]; None if there was none."""
    whirl_frequency_hz: float | None
    """Dominant whirl after the onset, positive = forward [Hz]."""
    mean_radius: float
    """Orbit radius over the clearance, mean of marks and of the second half of the run [-]."""
    contact_fraction: float
    """Share of nodes at the wall, mean of the second half of the run [-]."""
    cost: float
    """Processor time of the physics per simulated second [s/s]."""
    iteration_cost: float
    """Processor time per Newton iteration and element [s]; independent of how many iterations the motion takes."""

    def to_dict(self) -> dict[str, float | None]:
        """Plain numbers for JSON."""
        return asdict(self)


def run_trial(scene: Scene, seed: int | None = None) -> Trial:
    """Run a scene to its end.

    Args:
        scene: The scene; its kernel is compiled first, outside the cost.
        seed: Seed of a small random lateral velocity at time zero; None: start as the scene says.

    Raises:
        RunError: The motion could not be followed.
    """
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    first = schedule.at(period)
    Twin(scene).advance(first, period)
    twin = Twin(scene)
    if seed is not None:
        perturb(twin, seed)
    infos = mark_infos(scene)
    analyzer = Analyzer(infos)
    clearance = np.array([info.clearance for info in infos])
    frames = max(1, round(schedule.duration / period))
    radii, contact, spent, iterations = [], [], 0.0, 0
    for k in range(1, frames + 1):
        command = schedule.at(k * period)
        began = time.process_time()
        frame = twin.advance(command, period)
        spent += time.process_time() - began
        iterations += frame.stats.iterations
        marks = frame.marks
        analyzer.push(round(frame.time * 1e9), marks.position, marks.spin, frame.rig.top_drive_speed, marks.wall_force)
        if 2 * k > frames:
            radii.append(float(np.mean(np.hypot(marks.centre[:, 0], marks.centre[:, 1]) / clearance)))
            contact.append(float(np.mean(frame.wall_force > 0.0)))
    found = analyzer.summary()
    return Trial(
        found.onset_s,
        found.mode_frequency_hz,
        float(np.mean(radii)),
        float(np.mean(contact)),
        spent / schedule.duration,
        spent / (max(iterations, 1) * twin.elements),
    )


def perturb(twin: Twin, seed: int) -> None:
    """Add a small smooth random lateral velocity, so that chaotic runs diverge."""
    random = np.random.default_rng(seed)
    _, v = twin.unknowns
    arc = twin.rod.arc / twin.rod.arc[-1]
    for half_waves in range(1, WAVES + 1):
        wave = math.pi * half_waves
        for column in range(2):
            size = PERTURBATION * random.normal() / half_waves
            # sin^2 and its slope vanish at both ends, which fits every boundary condition
            v[:, column] += size * np.sin(wave * arc) ** 2
            v[:, 3 + column] += size * wave / twin.rod.arc[-1] * np.sin(2.0 * wave * arc)
