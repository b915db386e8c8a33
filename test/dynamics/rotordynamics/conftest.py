"""Equations of the bench in the lateral form, compiled once."""

import pytest

from drill_twin.api import load_scene
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion

LATERAL = {"effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "12"}


@pytest.fixture(scope="session")
def bench():
    return load_scene("pa6_bench", LATERAL)


@pytest.fixture
def equations(bench):
    return EquationsOfMotion(bench)
