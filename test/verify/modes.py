# SPDX-License-Identifier: Apache-2.0
"""Reading squared frequencies off a free motion, stable or growing: a signal tool, not a solver."""

import numpy as np
from numpy.typing import NDArray

from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.twin import Twin


def free_motion(scene: Scene, seconds: float, interval: float) -> NDArray[np.float64]:
    """Lateral place x of every node over a free motion [m], shape (samples, n + 1)."""
    twin = Twin(scene)
    command = Command(weight_on_bit=scene.rig.weight_on_bit.value, rotation=0.0)
    frames = [twin.step(command, interval) for _ in range(round(seconds / interval))]
    return np.array([frame.positions[:, 0] for frame in frames])


def squared_frequencies(motion: NDArray[np.float64], interval: float, modes: int) -> NDArray[np.float64]:
    """omega^2 [1/s2] of the strongest modes, ascending; negative for a mode that grows like cosh.

    An undamped mode obeys x(t + T) + x(t - T) = 2 c x(t) with c = cos(omega T) or cosh(sigma T), whatever its phase.
    Projected on the strongest shapes of the motion this is a small eigenvalue problem.
    """
    _, _, shapes = np.linalg.svd(motion, full_matrices=False)
    reduced = motion @ shapes[:modes].T
    mean = 0.5 * (reduced[2:] + reduced[:-2])
    matrix = np.linalg.lstsq(reduced[1:-1], mean, rcond=None)[0]
    c = np.sort(np.real(np.linalg.eigvals(matrix)))[::-1]
    angle = np.where(np.abs(c) <= 1.0, np.arccos(np.clip(c, -1.0, 1.0)), 0.0)
    growth = np.arccosh(np.maximum(c, 1.0))
    return (angle**2 - growth**2) / interval**2
