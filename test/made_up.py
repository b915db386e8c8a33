# SPDX-License-Identifier: Apache-2.0
"""Made-up frames of a string, repeatable random examples and ROS's own field checks: for the tests of the package and
of the evidence."""

import os
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import settings

from drill_twin.dynamics.twin.frame import Frame, MarkStates, RigState, StepStats

os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"  # read when the message modules are imported; off, an int is garbage

# The same random examples in every run: a change fails for what it changed, and on a slow machine as on a fast one.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

MARKS = ("mark_1", "mark_2", "mark_3", "mark_4")


def made_up_frame(nodes: int = 51, time: float = 1.5, seed: int = 1, marks: int = len(MARKS)) -> Frame:
    """A frame of random numbers, no two the same, with tangents of unit length and some nodes at the wall."""
    random = np.random.default_rng(seed)
    tangents = random.normal(scale=0.1, size=(nodes, 3)) + np.array((0.0, 0.0, 1.0))
    return Frame(
        time=time,
        positions=random.normal(size=(nodes, 3)),
        velocities=random.normal(size=(nodes, 3)),
        tangents=tangents / np.linalg.norm(tangents, axis=1, keepdims=True),
        spin=random.normal(scale=100.0, size=nodes),
        spin_rate=random.normal(size=nodes),
        wall_force=np.maximum(random.normal(size=nodes), 0.0),
        wall_depth=-0.01,
        wall_depth_at=2.0,
        marks=MarkStates(
            position=random.normal(size=(marks, 3)),
            velocity=random.normal(size=(marks, 3)),
            spin=random.normal(scale=100.0, size=marks),
            spin_rate=random.normal(size=marks),
            wall_force=random.uniform(size=marks),
            centre=random.normal(size=(marks, 3)),
        ),
        rig=RigState(*random.normal(size=12).tolist()),
        stats=StepStats(steps=10, iterations=20, cut_steps=0, steps_above_tolerance=0, wall_seconds=0.001),
    )


@pytest.fixture(scope="session")
def make_frame() -> Callable[..., Frame]:
    return made_up_frame
