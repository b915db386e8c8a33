"""Steady whirl states of the bench, against their equations and against the simulation in time."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.api import load_scene, override
from drill_twin.cli.app import app
from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.dynamics.rotordynamics.campbell import growth_map
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady import whirl_states as states_module
from drill_twin.dynamics.rotordynamics.steady.imperfections import imperfect, locked_states, modulation
from drill_twin.dynamics.rotordynamics.steady.shape_search import ShapeSearch
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_states import rolling_ratios, state_near, whirl_states
from drill_twin.dynamics.rotordynamics.turning_frame import quarter_turn
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model.mesh import SPIN
from drill_twin.runs.ensemble.parts import parts_of, planned
from drill_twin.scene.set_points import Schedule
from drill_twin.scene.set_points.command import Command

FAST = Command(40.0, 6.5 * math.tau)


def departure(scene, state, seconds, push=0.0):
    """Times, distance from the state over the clearance, and angle of the whirl, in a simulation that begins on it."""
    dynamics = Dynamics(scene)
    parameters = dynamics.parameters
    parameters.bow.moment[:] = parameters.eccentricity.imbalance[:] = parameters.eccentricity.inertia[:] = 0.0
    u, v, _ = state.whirl.motion
    start, clearance = u[:, 0] + 1j * u[:, 1], float(dynamics.model.wellbore.clearance.min())
    command = state.whirl.command
    dynamics.begin(u * (1.0 + push), v, command)
    found = []
    for _ in range(round(seconds / 0.01)):
        assert dynamics.advance(command.array(), 0.01, step=1e-3)
        now = dynamics.unknowns[0][:, 0] + 1j * dynamics.unknowns[0][:, 1]
        turn = np.vdot(start, now)
        found.append((dynamics.time, np.abs(now - start * turn / abs(turn)).max() / clearance, np.angle(turn)))
    times, apart, angle = np.array(found).T
    return times, apart, np.unwrap(angle)


def test_a_state_is_an_equilibrium_in_its_frame(fast):
    equations, states = fast
    assert any(state.is_stable for state in states)
    for state in states:
        residual = equations.evaluate(FAST, *state.whirl.motion).residual
        assert np.abs(residual).max() < 1e-8
        assert state.whirl.radius.max() > 0.99 * float(equations.model.wellbore.clearance.min())


def test_the_turn_of_the_whole_shape_is_neutral(fast):
    equations, states = fast
    turning = TurningEquations(equations)
    system, whirl = turning.at(states[0].whirl), states[0].whirl
    turned = turning.frame.values(quarter_turn(whirl.u))
    matrix = system.rows.dense(turning.stiffness(system, whirl.omega))
    assert np.abs(matrix @ turned).max() < 1e-4 * (np.abs(matrix) @ np.abs(turned)).max()


def test_newton_finds_a_state_again_from_near(fast):
    equations, states = fast
    state = next(state for state in states if state.is_stable)
    near = SteadyWhirl(FAST, state.whirl.u, state.whirl.omega * 1.001)
    again = TurningEquations(equations).newton(near)
    assert again is not None
    assert again.omega == pytest.approx(state.whirl.omega, rel=1e-9)


@pytest.mark.long
def test_the_simulation_stays_on_a_stable_state_and_turns_at_its_speed(bench, fast):
    state = next(state for state in fast[1] if state.is_stable)
    times, apart, angle = departure(bench, state, 3.0)
    assert apart.max() < 1e-3
    assert (angle[-1] - angle[0]) / (times[-1] - times[0]) == pytest.approx(state.whirl.omega, rel=1e-4)


@pytest.mark.long
def test_a_run_that_begins_in_a_whirl_keeps_its_speed_with_bow_and_eccentricity(bench, fast):
    state = max((one for one in fast[1] if one.is_stable), key=lambda one: one.ratio)
    scene = override(bench, {"rig.start": "whirl-state", "wob": 40.0, "rpm": "6.5 rev/s", "duration": 4.0})
    twin, schedule, angles = Twin(scene), Schedule.from_scene(scene), []
    assert schedule.at(0.0) == FAST
    for k in range(1, 401):
        twin.advance(schedule.at(0.01 * k), 0.01)
        angles.append(math.atan2(*twin.unknowns[0][5, [1, 0]]))
    speed = (np.unwrap(angles)[-1] - angles[0]) / 3.99
    assert speed == pytest.approx(state.whirl.omega, rel=0.01)


def test_a_start_in_a_whirl_needs_one(bench, monkeypatch):
    monkeypatch.setattr(states_module, "whirl_states", lambda *_: ())
    scene = override(bench, {"rig.start": "whirl-state", "wob": 0.0, "rpm": 60})
    with pytest.raises(RunError, match="expected a steady whirl at 0 N and 1 rev/s, found none"):
        Dynamics(scene)


def whirl_of_a_run(scene):
    """Whirl frequency [Hz] over the last third of a run, its scatter between windows over the rotation, and the motion
    in the frame of the whirl over the clearance.
    """
    commands, frame = planned(scene)
    places = (part.rows.centre for part in parts_of(Twin(scene), commands, frame))
    path = np.concatenate([centre[..., 0] + 1j * centre[..., 1] for centre in places])
    path = path[len(path) * 2 // 3 - 1 :]
    angle = np.unwrap(np.angle(path[:, np.argmax(np.mean(np.abs(path), axis=0))]))
    edges = np.linspace(0, angle.size - 1, 6).astype(int)
    rates = np.diff(angle[edges]) / (np.diff(edges) * frame)
    turned = path * np.exp(-1j * angle)[:, None]
    change = np.sqrt(np.mean(np.abs(turned - turned.mean(axis=0)) ** 2, axis=0)).max() / scene.least_clearance
    frequency = (angle[-1] - angle[0]) / ((angle.size - 1) * frame) / math.tau
    return frequency, rates.std() / scene.rig.rotation.value, change


@pytest.mark.long
@pytest.mark.parametrize(("weight", "turns"), [(20.0, 4.0), (60.0, 2.0), (60.0, 6.5), (150.0, 4.0)])
def test_a_run_from_the_axis_ends_on_a_stable_state(weight, turns):
    """Guided bit, with bow and eccentricity: the whirl speed of the run is that of a stable state."""
    held = {"string.bit_end": "guided", "effects.bit_friction.coefficient": "0", "numerics.elements": "16"}
    scene = load_scene("pa6_calibrated", {**held, "effects.stretch": "off", "effects.torsion": "off"})
    frequency, scatter, change = whirl_of_a_run(override(scene, {"wob": weight, "rpm": f"{turns} rev/s"}))
    assert max(scatter, change) < 0.02
    found = whirl_states(EquationsOfMotion(scene), Command(weight, turns * math.tau), random_starts=1)
    assert min(abs(state.ratio - frequency / turns) for state in found if state.is_stable) < 2e-3


@pytest.mark.slow
def test_a_state_on_the_command_line(tmp_path):
    """The states as JSON; their figure."""
    form = ["--set", "effects.stretch=off", "--set", "effects.torsion=off", "--set", "numerics.elements=12"]
    arguments = ["whirl", "pa6_bench", "--wob", "40 N", "--rpm", "6.5 rev/s", "--starts", "0", "--json"]
    said = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path), *form])
    assert said.exit_code == 0, said.output
    found = json.loads(said.stdout)
    assert found
    assert all(state["rotation_rev_s"] == pytest.approx(6.5) for state in found)
    assert json.loads((tmp_path / "states.json").read_text()) == found
    assert (tmp_path / "states.png").stat().st_size > 10_000


@pytest.mark.parametrize(("radius", "slowest", "count"), [("90 mm", -1.05, 43), ("13.5 mm", -1.65, 55)])
def test_whirl_speeds_are_tried_up_to_rolling(bench, monkeypatch, radius, slowest, count):
    """In a narrow hole a string that rolls whirls faster than it turns: 8.25 mm over 5.25 mm."""
    equations = EquationsOfMotion(override(bench, {"hole.radius": radius}))
    search, tried = ShapeSearch(TurningEquations(equations), FAST), []
    monkeypatch.setattr(search, "relax", lambda _start, omega, _steps: tried.append(omega))
    assert not search.family(search.axis)
    assert len(tried) == count
    assert tried[0] == pytest.approx(1.05 * FAST.rotation)
    assert tried[-1] == pytest.approx(slowest * FAST.rotation)


def test_scenes_without_a_steady_whirl_are_told(bench):
    hole = bench.hole.model_copy(update={"inclination": 0.5})
    with pytest.raises(SceneError, match="in which no steady whirl exists"):
        whirl_states(EquationsOfMotion(bench.model_copy(update={"hole": hole})), FAST)
    with pytest.raises(SceneError, match="expected a rotation other than 0"):
        whirl_states(EquationsOfMotion(bench), Command(40.0, 0.0))


def test_bow_modulates_a_state_as_in_the_linear_equations(fast):
    """A thousandth of the first-order motion satisfies the equations with a thousandth of bow and eccentricity."""
    equations, states = fast
    turning = TurningEquations(equations)
    whirl = next(state for state in states if state.is_stable).whirl
    found = modulation(turning, whirl)
    assert found.rate == pytest.approx(FAST.rotation - whirl.omega)
    assert 1e-5 < found.size / turning.clearance < 0.05
    residuals = []
    for share in (0.0, 1.0):
        wave = 1e-3 * share * np.exp(0.7j) * found.amplitude
        u, rate, swing = (np.real(wave * (1j * found.rate) ** k) for k in range(3))
        place, speed, acceleration = (row.copy() for row in replace(whirl, u=whirl.u + u).motion)
        place[:, SPIN] = 0.7  # the direction of the bow in the frame of the whirl
        acceleration += 2.0 * whirl.omega * quarter_turn(rate) + swing
        with imperfect(equations, 1e-3):
            residual = equations.evaluate(FAST, place, speed + rate, acceleration).residual
        residuals.append(float(np.abs(residual).max()))
    assert residuals[1] < 0.02 * residuals[0]


def test_the_bent_string_turns_with_the_rotation_near_the_axis(fast):
    """A locked state satisfies the equations with bow; on the axis it grows as the string there does."""
    equations, _ = fast
    turning = TurningEquations(equations)
    near_axis = min(locked_states(turning, FAST), key=lambda state: float(state.whirl.radius.max()))
    with imperfect(equations):
        assert np.abs(turning.at(near_axis.whirl).residual).max() < 1e-8
    assert np.abs(turning.at(near_axis.whirl).residual).max() > 1e-6
    assert near_axis.kind == "locked"
    assert 0.0 < near_axis.whirl.radius.max() < 0.01 * turning.clearance
    axis = growth_map(equations, np.array([FAST.weight_on_bit]), np.array([FAST.rotation])).lateral[0, 0]
    assert near_axis.growth == pytest.approx(axis, rel=1e-3)


def test_a_state_is_found_again_from_a_shape_and_speed_of_a_run(fast):
    equations, states = fast
    state = next(state for state in states if state.is_stable)
    u, _ = equations.on_axis(FAST)
    near = state_near(equations, SteadyWhirl(FAST, u + 1.02 * (state.whirl.u - u), state.whirl.omega * 1.003))
    assert near.ratio == pytest.approx(state.ratio, rel=1e-6)
    assert state_near(equations, SteadyWhirl(FAST, u, state.whirl.omega)) is None


@pytest.mark.parametrize(("collars", "ratios"), [("8 in", (-1.882, -0.815)), ("5.5 in", (-0.815,))])
def test_collars_and_pipe_roll_at_speeds_of_their_own(collars, ratios):
    """Minus radius over clearance in a hole of 6 1/8 in."""
    scene = load_scene("bha_full_size", {"string.sections.0.outer_diameter": collars})
    assert rolling_ratios(discretise(scene, mesh(scene, 20))) == pytest.approx(ratios, abs=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(("collars", "is_steady"), [("8 in", False), ("5.5 in", True)])
def test_a_steel_assembly_whirls_steadily_with_one_diameter_alone(collars, is_steady):
    """Collars and pipe roll each at their own speed; with the diameter of the pipe all of the string rolls at one."""
    forms = {"effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "40"}
    scene = load_scene("bha_full_size", forms | {"string.sections.0.outer_diameter": collars})
    twin, schedule, path = Twin(scene), Schedule.from_scene(scene), []
    for k in range(1, 2001):
        twin.advance(schedule.at(0.02 * k), 0.02)
        path.append(twin.unknowns[0][:, 0] + 1j * twin.unknowns[0][:, 1])
    angle = np.unwrap(np.angle(path[-600:]), axis=0)
    places = np.searchsorted(twin.rod.arc, [64.0, 389.0])
    rates = ((angle[-1] - angle[0]) / (599 * 0.02) / scene.rig.rotation.value)[places]
    ratios = rolling_ratios(twin.model)
    assert rates == pytest.approx([ratios[0], ratios[-1]], rel=0.01)
    assert (len(ratios) == 1) is is_steady


@pytest.mark.parametrize(("limit", "taken"), [(0, []), (2, ["a", "b"])])
def test_a_search_is_cut_short_by_its_work(bench, monkeypatch, limit, taken):
    """No first guess is taken after the limit, which counts evaluations, not seconds."""
    tried = []

    def add(turning, guess, _):
        tried.append(guess)
        turning.equations.evaluations += 1

    monkeypatch.setattr(states_module, "_guesses", lambda *_: iter("abc"))
    monkeypatch.setattr(states_module, "_add_near", add)
    assert whirl_states(EquationsOfMotion(bench), Command(40.0, 12.0), evaluations=limit) == ()
    assert tried == taken
    whirl_states(EquationsOfMotion(bench), Command(40.0, 12.0))
    assert tried == [*taken, *"abc"]
