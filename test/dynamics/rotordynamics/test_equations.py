"""The equations at an instant: tangents against differences of the residual, symmetry, what has no steady state."""

import numpy as np
import pytest

from drill_twin.core.errors import SceneError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, without
from drill_twin.dynamics.rotordynamics.turning_frame import TurningFrame, quarter_turn
from drill_twin.scene.set_points.command import Command

COMMAND = Command(40.0, 12.0)


def whirling(equations, omega=-3.0, size=1.001):
    """The string bent onto the wall, its bit off the axis, in whirl: position, velocity, acceleration."""
    u, v = equations.on_axis(COMMAND)
    arc, clearance = equations.model.rod.arc, float(equations.model.wellbore.clearance.min())
    wave = np.pi / arc[-1]
    u[:, 0] += size * clearance * np.sin(wave * arc) ** 2
    u[:, 3] += size * clearance * wave * np.sin(2.0 * wave * arc)
    u[0, 0] += 0.3 * clearance
    turned = quarter_turn(u)
    return u, v + omega * turned, omega**2 * quarter_turn(turned)


@pytest.mark.slow
@pytest.mark.parametrize(("number", "step"), [(0, 1e-8), (1, 1e-6), (2, 1e-4)], ids=["stiffness", "damping", "mass"])
def test_tangents_are_derivatives_of_the_residual(equations, number, step):
    state = list(whirling(equations))
    matrix = equations.evaluate(COMMAND, *state).matrices[2 - number]
    random = np.random.default_rng(1)
    for _ in range(3):
        direction = random.normal(size=equations.unknowns)
        ends = []
        for sign in (1.0, -1.0):
            moved = list(state)
            moved[number] = state[number] + sign * step * equations.rows(direction)
            ends.append(equations.evaluate(COMMAND, *moved).residual)
        difference = (ends[0] - ends[1]) / (2.0 * step)
        assert matrix @ direction == pytest.approx(difference, abs=1e-5 * np.abs(difference).max())


def test_residual_on_the_axis_is_zero_without_imperfections(equations):
    u, v = equations.on_axis(COMMAND)
    assert not equations.evaluate(COMMAND, u, v, np.zeros_like(u)).residual.any()


def test_the_axis_is_the_axis_after_any_evaluation(equations):
    u, _ = equations.on_axis(COMMAND)
    equations.evaluate(COMMAND, *whirling(equations))
    again, _ = equations.on_axis(COMMAND)
    assert (again == u).all()


def test_equations_look_the_same_from_every_direction(equations):
    frame = TurningFrame(equations)
    u, v, a = whirling(equations)
    once = equations.evaluate(COMMAND, u, v, a)
    turned_v = quarter_turn(v)
    turned_v[:, 6] = v[:, 6]
    turned = equations.evaluate(COMMAND, quarter_turn(u), turned_v, quarter_turn(a))
    assert turned.residual[frame.x] == pytest.approx(-once.residual[frame.y], abs=1e-9)
    assert turned.residual[frame.y] == pytest.approx(once.residual[frame.x], abs=1e-9)


def test_effects_that_depend_on_time_are_named(bench):
    noisy = bench.model_copy(update={"effects": bench.effects.model_copy(update={"random_force": object()})})
    with pytest.raises(SceneError, match=r"found random_force \(a .*\); --without random_force leaves it out"):
        EquationsOfMotion(noisy)
    EquationsOfMotion(without(noisy, ["random_force"]))
    with pytest.raises(SceneError, match="expected an effect of the scene"):
        without(bench, ["random_force"])
