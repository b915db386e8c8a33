"""Modes, Campbell diagram and map of growth rates of the bench."""

import numpy as np
import pytest

from drill_twin.errors import RunError
from drill_twin.rotordynamics.campbell import campbell, mac
from drill_twin.rotordynamics.growth_map import growth_map
from drill_twin.rotordynamics.modes import modes
from drill_twin.schedule.command import Command


def test_a_basis_of_few_modes_gives_the_growth_of_all(equations):
    weights, speeds = np.array([2.0, 20.0]), np.array([4.0, 20.0])
    few = growth_map(equations, weights, speeds).lateral
    for i, weight in enumerate(weights):
        for k, speed in enumerate(speeds):
            full = modes(equations, Command(weight, speed), count=100).fastest("lateral").growth
            assert few[i, k] == pytest.approx(full, abs=2e-3)


def test_campbell_follows_each_mode_and_finds_its_critical_speed(equations):
    speeds = np.linspace(0.5, 20.0, 20)
    diagram = campbell(equations, 5.0, speeds)
    steps = np.abs(np.diff(diagram.eigenvalues, axis=0)).max(axis=0)
    assert (steps[:5] < 2.0).all()  # no jump from one mode to another
    mode, speed = diagram.critical[0]
    at = modes(equations, Command(5.0, speed), count=20).of("lateral")
    assert min(abs(one.eigenvalue.imag - speed) for one in at) < 0.01 * speed
    assert diagram.eigenvalues[0, mode].imag > 0.0


def test_mac_is_one_for_a_shape_and_its_multiple():
    shape = np.array([[1.0 + 1.0j], [2.0], [0.5j]])
    assert mac(shape, 3.0j * shape)[0, 0] == pytest.approx(1.0)
    assert mac(shape, np.array([[2.0], [-1.0 + 1.0j], [0.0]]))[0, 0] == pytest.approx(0.0, abs=1e-12)


def test_growth_map_has_the_buckling_load_at_low_speed(equations):
    found = growth_map(equations, np.linspace(6.0, 12.0, 7), np.array([0.05]))
    onset = found.onset(found.lateral)[0]
    stiff = []
    for weight in (8.0, 9.5):
        stiffness = modes(equations, Command(weight, 0.05)).balance.system.stiffness
        stiff.append(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0])
    assert stiff[0] > 0.0 > stiff[1]
    assert 8.0 < onset < 9.5


def test_an_inclined_hole_has_no_string_on_the_axis(bench):
    from drill_twin.rotordynamics.equations import EquationsOfMotion

    inclined = bench.model_copy(update={"hole": bench.hole.model_copy(update={"inclination": 0.5})})
    equations = EquationsOfMotion(inclined)
    with pytest.raises(RunError, match="expected a straight vertical hole"):
        campbell(equations, 5.0, np.array([1.0, 2.0]))
