# SPDX-License-Identifier: Apache-2.0
"""A string with lateral motion from a depth on only, beside the whole one."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.joint import LONGEST_ABOVE, buckled_up_to, joined_workspace, joint_of
from drill_twin.dynamics.discretisation.notes import notes_on
from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
from drill_twin.dynamics.solver.joined import elements
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model.section_stress import SCALARS
from drill_twin.report.quantities import wall_depth
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command

AUTO = {"numerics.lateral_from": "auto"}
WHOLE = {"numerics.lateral_from": "0 m"}
FROM_REST = {"rig.start": "axis", "rig.rotation.shape": "step", "rig.rotation.duration": "10 s",
             "rig.weight_on_bit.shape": "step", "rig.weight_on_bit.start": "10 s",
             "rig.weight_on_bit.duration": "10 s"}  # fmt: skip
"""The string is spun up before the weight comes on, which leaves it in stick-slip."""


@pytest.mark.parametrize(("name", "least"), [("s_shaped", 112.5), ("vertical_3000", 200.0), ("extended_reach", 30.0)])
def test_auto_keeps_the_assembly_and_says_where_it_ends(name, least):
    scene = load_scene(f"wells/{name}")
    joint = joint_of(scene)
    assert least + 30.0 < joint < least + 300.0
    rod = mesh(scene, resolution_of(scene)[0])
    assert rod.length.size == resolution_of(scene)[0]
    assert np.isclose(rod.arc, joint).any()
    assert rod.length[rod.arc[:-1] > joint - 1e-6].max() <= LONGEST_ABOVE
    assert notes_on(scene)[0] == (
        f"lateral motion from {scene.length - joint:.4g} m down (`numerics.lateral_from`); above, the string follows "
        "the hole; marks on the axis: middle"
    )
    assert joint_of(load_scene(f"wells/{name}", overrides=WHOLE)) is None


def test_pipe_that_may_buckle_keeps_its_lateral_motion():
    heavy = {"rig.weight_on_bit.value": "600 kN", "string.sections[4].yield_strength": "5 GPa"}
    scene = load_scene("wells/s_shaped", overrides=AUTO | heavy)
    buckled = buckled_up_to(scene)
    assert buckled > 200.0
    assert joint_of(scene) > buckled
    late = load_scene("wells/s_shaped", overrides=heavy | {"numerics.lateral_from": "2700 m"})
    assert f"at most {scene.length - buckled:.4g} m" in notes_on(late)[1]
    field = late.model_copy(update={"units": "field"})
    assert f"at most {(scene.length - buckled) / 0.3048:.4g} ft" in notes_on(field)[1]


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ({"effects.lateral_kick": "{velocity: 0 m/s, offset: 1 mm}"}, "effects.lateral_kick.offset"),
        ({"effects.top_shake": "{amplitude: 1 mm, frequency: 1 Hz}"}, "effects.top_shake"),
        ({"rig.start": "equilibrium"}, "rig.start: equilibrium"),
    ],
)
def test_what_needs_the_whole_string_moves_all_of_it_with_auto_and_is_refused_with_a_depth(more, named):
    scene = load_scene("wells/vertical_3000", overrides=more)
    assert joint_of(scene) is None
    assert notes_on(scene)[0] == f"`numerics.lateral_from: auto` is 0 m: the whole string moves laterally, for {named}"
    with pytest.raises(SceneError, match=named):
        load_scene("wells/vertical_3000", overrides={"numerics.lateral_from": "2700 m"} | more)


def test_a_joint_below_the_bit_is_refused():
    with pytest.raises(SceneError, match="expected a depth above the bit"):
        load_scene("wells/s_shaped", overrides={"numerics.lateral_from": "3000 m"})


def test_a_push_moves_only_what_may_move_laterally():
    scene = load_scene(
        "wells/s_shaped", overrides=AUTO | {"rig.start": "axis", "effects.lateral_kick.velocity": "1 mm/s"}
    )
    twin = Dynamics(scene)
    first = int(np.searchsorted(twin.rod.arc, joint_of(scene) - 1e-6))
    speeds = twin.unknowns[1]
    assert not speeds[first:].any()
    assert speeds[1:first, 0].all()


def test_the_depth_asked_for_buckled_pipe_is_not_negative():
    notes = notes_on(load_scene("pa6_bench", overrides={"numerics.lateral_from": "1 m"}))
    assert any(note.endswith("lateral_from at most 0 m") for note in notes)


@pytest.mark.parametrize("depth", ["2400 m", "2663 m", "2813 m"])
def test_the_side_force_has_the_whole_of_each_dogleg(depth):
    """Wherever the elements end: their doglegs sum up to the 40 degrees of the build and the 30 of the drop."""
    scene = load_scene("wells/s_shaped", overrides={"numerics.lateral_from": depth})
    rod = mesh(scene, resolution_of(scene)[0])
    work = joined_workspace(scene, discretise(scene, rod), np.zeros((2, 7), bool))
    turned = (work.points.curvature * np.repeat(0.5 * rod.length[-work.twist.size :], 2)).sum()
    gone = 5.0 if depth == "2400 m" else 0.0  # of the drop, below the joint
    assert np.degrees(turned) == pytest.approx(70.0 - gone, abs=1e-2)


def test_a_short_string_moves_laterally_as_a_whole():
    assert joint_of(load_scene("pa6_bench", overrides=AUTO)) is None


STRAIGHT = {"rig.start": "axis", "effects.eccentricity.offset": "0 mm", "rig.rotation.value": "40 rpm"}


@pytest.mark.long
def test_a_straight_string_on_its_axis_is_the_same_with_and_without():
    """On one mesh stretch, twist and stick-slip differ by the tolerance of Newton's method only."""
    whole = load_scene("wells/vertical_3000", overrides=STRAIGHT | WHOLE | {"numerics.elements": "120"})
    joined = load_scene("wells/vertical_3000", overrides=STRAIGHT | {"numerics.lateral_from": "1500 m"})
    rod = Dynamics(joined).rod
    ends = []
    for scene in (whole, joined):
        dynamics = Dynamics(scene, rod)
        for time in np.arange(0.0, 15.0, 0.02):
            dynamics.advance(np.array([min(time, 10.0) * 1e4, min(time / 10.0, 1.0) * 4.0, 0.0]), 0.02)
            dynamics.command[:] = [min(time, 10.0) * 1e4, min(time / 10.0, 1.0) * 4.0, 0.0]
        ends.append(np.vstack(dynamics.unknowns)[:, [2, 5, 6]])
    scale = np.abs(ends[0]).max(axis=0)
    assert np.all(np.abs(ends[1] - ends[0]).max(axis=0) < 1e-4 * scale)


def test_the_deepest_place_in_the_wall_is_below_the_joint():
    """The element above the joint bends with the string below it and meets no wall."""
    scene = load_scene("wells/s_shaped", overrides=AUTO)
    result, joint = dt.Simulation(scene).run(duration=3), joint_of(scene)
    own = result.recording
    told = ["near_bit", "stabiliser", "collars"]  # no lateral acceleration of `middle`, which stays on the axis
    assert list(result.summary["acceleration"]) == list(result.summary["wear_power_w"]) == told
    position, arc = own.poses.position.copy(), mesh(scene, resolution_of(scene)[0]).arc
    poses = SimpleNamespace(time=own.poses.time, position=position, tangent=own.poses.tangent)
    bag = SimpleNamespace(scene_known=True, scene=scene, nodes=own.nodes, poses=poses)
    found, node = wall_depth(bag), int(np.argmin(np.abs(arc - joint)))
    position[:, node + 1, 0] += 0.5
    assert wall_depth(bag) == pytest.approx(found, rel=1e-4)
    position[:, node - 1, 0] += 0.5
    assert joint - 30.0 < wall_depth(bag)["distance_from_bit_m"] < joint


@pytest.mark.long
def test_the_energy_balance_closes_over_the_joint():
    """With the friction of both parts, gravity along the curved hole, damping and drive: what Newton's method leaves.

    Work taken out of the books, such as the friction above the joint, would be missing.
    """
    twin = Twin(load_scene("wells/s_shaped", overrides=AUTO | {"rig.start": "axis", "numerics.audit": "energy"}))
    frames = [twin.advance(Command(2e4 * min(k / 50.0, 1.0), 6.0 * min(k / 50.0, 1.0)), 0.02) for k in range(1, 151)]
    last, books = frames[-1].energy, [frame.energy for frame in frames]
    assert max(abs(energy.residual - energy.newton) for energy in books) < 1e-10 * last.scale
    assert max(abs(energy.residual) for energy in books) < 1e-5 * last.scale
    assert last.work["top_drive"] > 0.5 * last.scale
    assert last.dissipated["wall_friction"] > 0.2 * last.scale
    assert abs(last.work["gravity"]) > 1e-3 * last.scale


@pytest.mark.long
def test_a_curved_string_is_that_of_the_whole_one_within_a_hundredth():
    """Hookload and torque over the rotating part of the run, period of stick-slip (docs/accuracy.md)."""
    found = []
    for more in (WHOLE, AUTO):
        result = dt.Simulation(load_scene("wells/s_shaped", overrides=FROM_REST | more)).run(duration=40)
        late = np.asarray(result.time) > 10.0
        (slip,) = result.summary["stick_slip"]
        found.append(
            (np.mean(np.asarray(result.hookload)[late]), np.mean(np.asarray(result.torque)[late]), slip["period_s"])
        )
    assert np.allclose(found[1], found[0], rtol=0.01)


def test_effects_above_the_joint_are_given_the_turn_of_the_string():
    """An effect that is fixed in the material turns with it, above the joint as below."""
    scene = load_scene("wells/s_shaped", overrides=AUTO)
    rod = mesh(scene, resolution_of(scene)[0])
    work = joined_workspace(scene, discretise(scene, rod), np.zeros((2, 7), bool))
    work.here[:, 0], work.here[:, 1] = rod.arc[-work.here.shape[0] :] - rod.arc[-1], 1.0
    work.here[:, 2] = np.linspace(0.3, 40.0, len(work.here))
    seen = []
    effects = SimpleNamespace(axial_damping=lambda *_: (0.0, 0.0))
    assemble = elements.bind(
        effects,
        lambda _, __, strain, *___: seen.append((strain.psi, strain.cos_psi, strain.sin_psi)),
        lambda _, __, here, *___: seen.append((here.spin, here.cos_spin, here.sin_spin)),
        lambda *_: (0.0,) * 6,
    )
    as_python(assemble)(None, rod, work, 0.0, 1e-3, True, 0.0)
    turn, cos, sin = np.array(seen).T
    assert len(seen) == 4 * work.twist.size
    assert cos == pytest.approx(np.cos(turn))
    assert sin == pytest.approx(np.sin(turn))
    assert np.ptp(turn) > 30.0


@pytest.mark.long
def test_a_jar_above_the_joint_hangs_on_the_hook_and_has_its_mass():
    """The string above the joint carries a disc: weight along the hole, mass and polar inertia."""
    jar = "[{name: jar, distance_from_bit: 600 m, mass: 900 kg, polar_inertia: 40 kg m^2}]"
    cut = {"numerics.lateral_from": "2700 m", "numerics.audit": "energy"}
    plain = Twin(load_scene("wells/vertical_3000", overrides=cut))
    heavy = Twin(load_scene("wells/vertical_3000", overrides=cut | {"string.discs": jar}))
    assert heavy.dynamics.form == "joined"
    command = Command(*heavy.scene.rig.first)
    frames = [[twin.advance(command, 0.02) for _ in range(10)][-1] for twin in (plain, heavy)]
    more = frames[1].rig.hookload - frames[0].rig.hookload
    gravity = heavy.scene.effects.gravity.magnitude
    assert more == pytest.approx(900.0 * gravity, rel=0.02)
    assert abs(frames[1].energy.residual - frames[1].energy.newton) < 1e-4 * frames[1].energy.scale


def test_a_support_above_the_joint_holds_nothing_and_the_note_says_so():
    places = {"upper": 600, "near": 100}
    held = [{"name": name, "distance_from_bit": f"{at} m", "stiffness": "1e6 N/m"} for name, at in places.items()]
    scene = load_scene("wells/vertical_3000", overrides={"numerics.lateral_from": "2700 m", "string.supports": held})
    (note,) = [note for note in notes_on(scene) if "numerics.lateral_from" in note]
    assert note.endswith("supports that hold nothing: upper")


@pytest.mark.long
def test_fatigue_above_the_joint_is_of_the_bending_of_the_hole_and_the_note_says_so():
    """Half-way through the build, 20 degrees in 300 m: E r / R beside the stress of the tension."""
    places = "[{name: low, distance_from_bit: 60 m}, {name: build, distance_from_bit: 2000 m}]"
    scene = load_scene("wells/s_shaped", overrides={"effects.fatigue": f"{{sections: {places}}}"})
    assert notes_on(scene)[0].endswith("marks on the axis: middle; fatigue of the hole's bending only: build")
    twin = Twin(scene)
    frame = [twin.advance(Command(0.0, 0.2), 0.02) for _ in range(5)][-1]
    build = dict(zip(SCALARS, frame.stress[1], strict=True))
    pipe = scene.string.section_at(2000.0)
    bending = 207e9 * math.pi / 64.0 * (pipe.outer_diameter**4 - pipe.inner_diameter**4) * math.radians(20.0) / 300.0
    assert math.hypot(build["moment_x"], build["moment_y"]) == pytest.approx(bending, rel=0.01)
