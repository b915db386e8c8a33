# SPDX-License-Identifier: Apache-2.0
"""What exact numbers do not show: that they are come by cheaply."""

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.scenes import ROLLING, WALLED, quiet_scene


def test_newton_does_not_circle_about_the_kink_of_friction() -> None:
    """A string that whirls into the wall and rolls there takes fewer than 2.5 iterations a step."""
    twin = Twin(quiet_scene(ROLLING, of=WALLED, step=2e-3, radius=0.04))
    iterations, steps = 0, 0
    for k in range(400):
        share = min((k + 1) * 0.01 / 2.0, 1.0)
        stats = twin.advance(Command(weight_on_bit=30.0 * share, rotation=2.0 * np.pi * share), 0.01).stats
        iterations, steps = iterations + stats.iterations, steps + stats.steps
    assert iterations < 2.5 * steps
