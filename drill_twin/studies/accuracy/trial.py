# SPDX-License-Identifier: Apache-2.0
"""Run of a scene that returns scalar results for comparison: onset, whirl, radius, contact, cost."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from drill_twin.core.missing import number_or_none
from drill_twin.scene import Scene
from drill_twin.studies.accuracy.motion_run import run_motion


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
    motion = run_motion(scene, seed)
    late = 2 * np.arange(1, motion.time.size + 1) > motion.time.size
    radius = np.hypot(motion.centre[late, :, 0], motion.centre[late, :, 1]) / motion.clearance
    return Trial(
        number_or_none(motion.onset),
        number_or_none(motion.frequency),
        float(radius.mean(axis=1).mean()),
        float(motion.contact[late].mean()),
        motion.cost,
        motion.cost / (max(motion.iteration_rate, 1.0) * motion.elements),
    )
