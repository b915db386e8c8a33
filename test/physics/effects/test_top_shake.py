# SPDX-License-Identifier: Apache-2.0
"""A shaken top: the string's exact steady answer, and the random shake's own motion."""

import numpy as np
import pytest
from rod_scenes import AT_REST, quiet_scene

from drill_twin.dynamics.twin.twin import Twin

AMPLITUDE, DIRECTION, DRAG = 1e-3, 0.7, 0.4


def test_the_top_itself() -> None:
    """It moves as A sin(2 pi f t) at A 2 pi f cos(2 pi f t), and returns to where it was."""
    shake = {"amplitude": AMPLITUDE, "frequency": 2.0}
    twin = Twin(quiet_scene({"drag": {"linear": DRAG}, "top_shake": shake}, form="lateral", step=2e-3))
    u, v = twin.unknowns
    assert v[-1, 0] == pytest.approx(AMPLITUDE * 4.0 * np.pi)
    for _ in range(300):
        twin.advance(AT_REST, 0.01)
        angle = 4.0 * np.pi * twin.time
        assert u[-1, 0] == pytest.approx(AMPLITUDE * np.sin(angle), abs=1e-4 * AMPLITUDE)
        assert v[-1, 0] == pytest.approx(AMPLITUDE * 4.0 * np.pi * np.cos(angle), abs=1e-9)
        assert u[-1, [1, 3, 4]] == pytest.approx(0.0)


def test_a_random_shake() -> None:
    """Mean square A^2 / 2, and of its velocity that times w_0^2 + (2 pi b)^2; over 200 s, within 10 %."""
    shake = {"amplitude": AMPLITUDE, "frequency": 2.0, "bandwidth": 0.5, "seed": 3}
    twin = Twin(
        quiet_scene(
            {"drag": {"linear": DRAG}, "top_shake": shake}, form="lateral", step=0.01, elements=4, frame_rate=20.0
        )
    )
    u, v = twin.unknowns
    rows = []
    for _ in range(4000):
        twin.advance(AT_REST, 0.05)
        rows.append((u[-1, 0], v[-1, 0]))
    place, speed = np.array(rows).T
    assert np.var(place) == pytest.approx(AMPLITUDE**2 / 2.0, rel=0.1)
    assert np.var(speed) == pytest.approx(AMPLITUDE**2 / 2.0 * (2.0 * np.pi) ** 2 * (2.0**2 + 0.5**2), rel=0.1)
