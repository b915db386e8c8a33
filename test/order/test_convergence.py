# SPDX-License-Identifier: Apache-2.0
"""Orders of convergence, read off as slopes: four in space, two in time."""

import numpy as np
import pytest
from scenes import rod_scene

from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

SPACE, TIME = 4.0, 2.0


def middle_path(elements: int, step: float) -> np.ndarray:
    """Path of mid-span in the first half second after a kick under a growing load [m], every 10 ms, shape (50, 2)."""
    kick = {"lateral_kick": {"velocity": 0.3, "shape": "hump"}}
    twin = Twin(rod_scene(effects=kick, elements=elements, step=step))
    frames = [twin.step(Command(weight_on_bit=0.6 * (k + 1), rotation=0.0), 0.01) for k in range(50)]
    return np.array([frame.marks.centre[0, [0, 2]] for frame in frames])


def slope(sizes: list[float], errors: list[float]) -> float:
    """Order: fitted slope of log error over log size."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def test_order_in_space() -> None:
    """Halving the elements divides the error by sixteen."""
    reference = middle_path(96, 1e-3)
    counts = [8, 12, 16, 24]
    errors = [np.abs(middle_path(n, 1e-3) - reference).max() / np.abs(reference).max() for n in counts]
    assert slope([1.0 / n for n in counts], errors) == pytest.approx(SPACE, abs=0.6)
    assert errors[-1] < 1e-4


def test_order_in_time() -> None:
    """Halving the step divides the error by four."""
    reference = middle_path(16, 2.5e-4)
    steps = [1e-2, 5e-3, 2.5e-3]
    errors = [np.abs(middle_path(16, step) - reference).max() / np.abs(reference).max() for step in steps]
    assert slope(steps, errors) == pytest.approx(TIME, abs=0.3)
