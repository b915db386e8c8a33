"""Equations of the bench in the lateral form, compiled once, and its steady whirls at a high speed."""

import math

import pytest

from drill_twin.api import load_scene
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.whirl_states import whirl_states
from drill_twin.scene.set_points.command import Command

FAST = Command(40.0, 6.5 * math.tau)
LATERAL = {"effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "12"}


@pytest.fixture(scope="session")
def bench():
    return load_scene("pa6_bench", LATERAL)


@pytest.fixture
def equations(bench):
    return EquationsOfMotion(bench)


@pytest.fixture(scope="session")
def fast(bench):
    equations = EquationsOfMotion(bench)
    return equations, whirl_states(equations, FAST, random_starts=0)
