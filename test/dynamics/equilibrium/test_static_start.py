# SPDX-License-Identifier: Apache-2.0
"""A run that begins in static equilibrium (`rig.start`); closed forms: `drill-twin study verify --only statics`."""

from pathlib import Path

import numpy as np
import pytest
from rod_scenes import EULER_LOAD, FIRST, WALLED, in_equilibrium, quiet_scene

from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
from drill_twin.dynamics.equilibrium import static_scene
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Command, Schedule
from drill_twin.studies.accuracy.errors import statistics
from drill_twin.studies.accuracy.motion_run import run_motion

CONFIG = Path(__file__).resolve().parents[3] / "config"
STILL = {"rig.start": "equilibrium", "rpm": "0"}


def fastest(twin: Twin, seconds: float) -> float:
    """Largest speed of a node over so long a time [m/s]."""
    command = Command(*twin.scene.rig.first)
    speeds = [np.abs(twin.advance(command, 0.02).velocities).max() for _ in range(round(seconds / 0.02))]
    return float(max(speeds))


def test_a_buckled_string_on_the_wall_lies_still() -> None:
    """Nothing is out of balance: two seconds on, it has hardly begun to move."""
    scene = in_equilibrium(quiet_scene({}, of=WALLED, weight_on_bit=30.0, radius=0.09))
    twin = Twin(scene)
    u, _ = twin.unknowns
    begun = u.copy()
    clearance = 0.09 - float(twin.rod.outer_radius[0])
    assert np.hypot(u[:, 0], u[:, 1]).max() == pytest.approx(clearance, rel=0.01)
    assert fastest(twin, 2.0) < 5e-5
    assert np.abs(u[:, :3] - begun[:, :3]).max() < 5e-5


def test_the_bit_turns_on_as_it_was_wound_up() -> None:
    """Below its buckling load the string of pa6_bench shows no transient: not of the ramp, nor of the bit's torque."""
    changes = {"rig.start": "equilibrium", "wob": "2 N", "rpm": "120", "effects.bow.amplitude": "0 m"}
    scene = load_scene("pa6_bench", overrides=changes)
    schedule = Schedule.from_scene(scene)
    assert schedule.at(0.0) == schedule.at(20.0) == Command(2.0, scene.rig.rotation.value)
    twin = Twin(scene)
    frames = [twin.advance(schedule.at(0.01 * k), 0.01).rig for k in range(1, 101)]
    speed = np.array([rig.bit_speed for rig in frames]) / scene.rig.rotation.value
    torque = 0.08 * 2.0 * 5.5e-3
    assert np.abs(speed - 1.0).max() < 1e-4  # without the wind-up 5e-3
    assert np.allclose([rig.top_drive_torque for rig in frames], torque, rtol=2e-3)
    assert np.ptp([rig.hookload for rig in frames]) < 1e-5
    spin = twin.unknowns[0][:, 6]
    assert spin[0] - spin[-1] == pytest.approx(-torque * 5.0 / twin.rod.torsion[0], rel=1e-2)


def test_a_string_in_an_inclined_hole_begins_on_the_low_side() -> None:
    scene = in_equilibrium(quiet_scene({"gravity": {"magnitude": 9.81}}, of=WALLED, inclination=1.0, radius=0.02))
    twin = Twin(scene)
    low = twin.unknowns[0][5:-5, 0]
    assert np.all(low > 0.9 * (0.02 - float(twin.rod.outer_radius[0])))
    assert fastest(twin, 1.0) < 1e-5


def test_swings_about_the_balance_are_those_of_the_loaded_string() -> None:
    """A kick after the start swings the straight string with omega^2 = FIRST^2 (1 - F / F_E), to 1 % (Galef 1968)."""
    kick = {"lateral_kick": {"velocity": 1e-3, "shape": "hump"}}
    twin = Twin(in_equilibrium(quiet_scene(kick, weight_on_bit=0.5 * EULER_LOAD, step=5e-3, form="lateral")))
    x = np.array([twin.advance(Command(*twin.scene.rig.first), 0.02).positions[12, 0] for _ in range(300)])
    crossings = 0.02 * (np.flatnonzero(np.diff(np.sign(x)))[[0, -1]])
    number = np.count_nonzero(np.diff(np.sign(x))) - 1
    assert np.pi * number / np.ptp(crossings) == pytest.approx(FIRST * np.sqrt(0.5), rel=0.02)


def test_no_equilibrium_is_said_clearly() -> None:
    """Far above its buckling load, with the wall far away, the string folds."""
    scene = in_equilibrium(quiet_scene({}, of=WALLED, weight_on_bit=10.0 * EULER_LOAD))
    with pytest.raises(RunError, match=r"rig\.start: expected a static equilibrium .* Start from the axis instead"):
        Twin(scene)


def test_a_record_has_no_final_value() -> None:
    with pytest.raises(SceneError, match='expected "axis" or "rotating" with a recorded `weight_on_bit`'):
        load_scene("ufrj_rig", overrides={"rig.start": "equilibrium"})


def test_both_forms_find_the_same_shape() -> None:
    """Apart from the side, which chance decides, and from slopes of 0.1 that only the spatial form takes in full."""
    shapes = [
        Twin(in_equilibrium(quiet_scene({}, of=WALLED, weight_on_bit=20.0, radius=0.09, form=form))).unknowns[0]
        for form in ("spatial", "lateral")
    ]
    radii = [np.hypot(u[:, 0], u[:, 1]) for u in shapes]
    assert np.abs(radii[0] - radii[1]).max() < 1e-4


def test_scene_reads_it() -> None:
    scene = load_scene("pa6_bench", overrides=STILL)
    assert isinstance(scene, Scene)
    assert scene.rig.first == (40.0, 0.0)
    assert load_scene("pa6_bench").rig.first == (0.0, 0.0)


@pytest.mark.slow
def test_whirl_is_that_of_a_run_with_ramps() -> None:
    """What comes of it does not depend on the start: orbits and contact; but it comes at once."""
    ramps = run_motion(load_scene("pa6_bench", overrides={"duration": "24 s"}))
    at_once = run_motion(load_scene("pa6_bench", overrides={"duration": "12 s", "rig.start": "equilibrium"}))
    assert ramps.onset > 5.0
    assert at_once.onset < 1.0
    radius, contact = statistics(at_once)
    assert radius == pytest.approx(statistics(ramps)[0], rel=0.05)
    assert contact == pytest.approx(statistics(ramps)[1], abs=0.1)


@pytest.mark.long
def test_the_search_has_the_mesh_of_the_run() -> None:
    """A graded mesh depends on the rotation, which the search is without: its state must fall on the same nodes."""
    scene = load_scene(CONFIG / "wells" / "vertical_3000.yaml", overrides={**STILL, "rpm": "120", "wob": "20 kN"})
    assert mesh(static_scene(scene), resolution_of(static_scene(scene))[0]).arc.size != Twin(scene).rod.arc.size
    assert mesh(static_scene(scene), 200).arc.tolist() != mesh(scene, 200).arc.tolist()  # with a given number too
    assert fastest(Twin(scene), 0.1) < 0.1
