# SPDX-License-Identifier: Apache-2.0
"""Forces along the string are those of the solver, found from its recorded poses alone."""

from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.drawing.transforms import orientation, spin_of, tangent_of
from drill_twin.report import draw
from drill_twin.report.recording import read_recording
from drill_twin.report.string_forces import string_forces
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Schedule

INCLINED = {"hole.inclination": "60 deg", "rig.start": "equilibrium", "rig.rotation.initial": "2 rev/s"}


@pytest.fixture(scope="module")
def frame_and_scene():
    """A string that rolls on the low side of its hole, half a second after its start in balance."""
    scene = load_scene("pa6_bench", overrides=INCLINED)
    twin, schedule = Twin(scene), Schedule.from_scene(scene)
    for k in range(50):
        frame = twin.advance(schedule.at(0.01 * (k + 1)), 0.01)
    return frame, scene


def seen(frame, scene):
    """What a bag would hold of a frame."""
    turned = orientation(frame.tangents, frame.spin)
    poses = SimpleNamespace(
        position=frame.positions[None], tangent=tangent_of(turned)[None], spin=spin_of(turned)[None],
        time=np.array([frame.time]),
    )  # fmt: skip
    return SimpleNamespace(scene=scene, nodes=len(frame.spin), poses=poses, rig=())


def test_side_force_is_that_of_the_wall(frame_and_scene):
    frame, scene = frame_and_scene
    found = string_forces(seen(frame, scene))
    total = (found.side[0] * -np.diff(found.depth)).sum()
    weight = sum(s.mass_per_length * s.length for s in scene.string.sections) * 9.81 * np.sin(np.radians(60.0))
    assert total == pytest.approx(frame.wall_force.sum(), rel=0.02)  # the damping of the wall is not in a pose
    assert total == pytest.approx(weight, rel=0.5)


def test_tension_and_torque_reach_what_is_recorded_at_the_ends(bench_run):
    recording = read_recording(bench_run.bag)
    found, rig = string_forces(recording, slice(-1, None)), recording.rig
    scene = recording.scene
    weight = sum(s.mass_per_length * s.length for s in scene.string.sections) * 9.81
    element = weight / found.tension.shape[1]
    assert found.tension[0, -1] == pytest.approx(rig.hookload[-1] - 0.5 * element, abs=0.01 * abs(rig.hookload[-1]))
    assert found.tension[0, 0] == pytest.approx(-rig.bit_force[-1] + 0.5 * element, abs=0.01 * abs(rig.hookload[-1]))
    assert found.torque[0, -1] == pytest.approx(rig.top_drive_torque[-1], rel=0.1)


def test_tension_jumps_by_the_weight_of_a_disc_at_the_disc():
    """Without `stretch` it follows from the weights; an element below a disc does not carry half of it."""
    scene = load_scene("rotor_kit", overrides={"hole.inclination": "0 deg", "rig.start": "axis"})
    frame = Twin(scene).advance(Schedule.from_scene(scene).at(0.01), 0.01)
    rig = namedtuple("Rig", "time bit_force")([0.0, 1.0], [0.0, 0.0])  # noqa: PYI024
    found = string_forces(SimpleNamespace(**vars(seen(frame, scene)) | {"rig": rig}))
    middle, disc = 0.5 * (found.depth[1:] + found.depth[:-1]), scene.string.body_of(scene.string.discs[0])[0]
    shaft = sum(s.mass_per_length for s in scene.string.sections) * (scene.length - middle)
    hung = sum((middle < scene.length - each.distance_from_bit) * disc for each in scene.string.discs)
    assert found.tension[0] == pytest.approx(9.80665 * (shaft + hung), rel=1e-3)


def test_twist_of_half_a_turn_an_element_is_counted(frame_and_scene):
    """A quaternion repeats after two turns, so the twist of an element is known up to one turn."""
    frame, scene = frame_and_scene
    nodes = len(frame.spin)
    arc = np.linspace(0.0, scene.length, nodes)
    straight = np.stack((0.0 * arc, 0.0 * arc, arc - scene.length), axis=1)
    up = np.broadcast_to([0.0, 0.0, 1.0], straight.shape)
    twisted = frame._replace(positions=straight, tangents=up, spin=np.pi * np.arange(nodes))
    found = string_forces(seen(twisted, scene))
    section = scene.string.sections[0]
    stiffness = section.shear_modulus * 2.0 * section.second_moment
    assert found.torque[0] == pytest.approx(stiffness * np.pi * (nodes - 1) / scene.length)
    assert found.tension[0] == pytest.approx(0.0, abs=1e-6)
    assert found.side[0] == pytest.approx(0.0)


def test_without_stretch_the_tension_is_that_of_balance_and_the_torque_unknown(known_bag):
    off = {"effects.stretch": "off", "effects.torsion": "off"}
    recording = read_recording(known_bag, load_scene("pa6_bench", overrides=off))
    found = string_forces(recording, slice(-1, None))
    weight = sum(s.mass_per_length * s.length for s in recording.scene.string.sections) * 9.81
    places = (np.arange(10) + 0.5) / 10.0
    assert found.tension[0] == pytest.approx(weight * places - recording.rig.bit_force[-1])
    assert np.isnan(found.torque).all()
    assert draw("well", recording).axes


def test_poses_of_another_mesh_have_no_forces(frame_and_scene):
    frame, scene = frame_and_scene
    recording = seen(frame, scene)
    recording.nodes = 1
    assert string_forces(recording) is None
