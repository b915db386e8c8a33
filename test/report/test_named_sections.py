# SPDX-License-Identifier: Apache-2.0
"""What is found along the string is named by the section that has it, also at a change of section."""

from types import SimpleNamespace

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.units.system import SYSTEMS
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.report.severity import STAYS
from drill_twin.report.string_forces import INSIDE, JOINT, fibre_stress, force_on_joint, left_torque
from drill_twin.scene import Scene, parse_scene

WELL = """
name: short sections
string:
  bit_end: pinned
  sections:
  - {name: stabiliser, length: 1.5 m, outer_diameter: 0.17 m, inner_diameter: 0.07 m, blade_diameter: 0.21 m}
  - {name: pony, length: 3 m, outer_diameter: 0.12 m, inner_diameter: 0.07 m}
  - {name: collars, length: 20 m, outer_diameter: 0.17 m, inner_diameter: 0.07 m}
  - {name: pipe, length: 30 m, outer_diameter: 0.127 m, inner_diameter: 0.11 m, make_up_torque: 30 kN m}
hole: {radius: 0.108 m}
rig:
  weight_on_bit: {value: 10 kN}
  rotation: {value: 60 rpm}
  duration: 10 s
effects: {gravity: {}, stretch: {}, torsion: {}, wall: {stiffness: 1e10 N/m^2.5}}
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return parse_scene(WELL)


def recorded(scene: Scene, off: np.ndarray, slope: np.ndarray, spin: np.ndarray) -> SimpleNamespace:
    """Recording of a string off the axis by `off` [m] with a slope along x, at poses of a spin [rad], (T, n + 1)."""
    arc = mesh(scene, 200).arc
    shape = np.stack([off, 0.0 * arc, arc - scene.length], axis=-1)
    tangent = np.stack([slope, 0.0 * arc, np.ones_like(arc)], axis=-1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    count = len(spin)
    poses = SimpleNamespace(
        position=np.broadcast_to(shape, (count, *shape.shape)), tangent=np.broadcast_to(tangent, (count, *shape.shape)),
        spin=spin, time=0.1 * np.arange(count),
    )  # fmt: skip
    return SimpleNamespace(scene=scene, nodes=arc.size, poses=poses, rig=(), units=SYSTEMS["si"])


def test_wall_force_on_a_joint_is_named_by_the_section_that_carries_it(scene):
    """The middle of 30 ft lies in the collars, or in a pony, while the stabiliser carries the force."""
    arc = mesh(scene, 200).arc
    force, place = force_on_joint(
        recorded(scene, np.full_like(arc, 0.004), 0.0 * arc, np.zeros((1, arc.size))), np.arange(1)
    )
    assert force == pytest.approx(1e10 * 0.001**1.5 * 1.5, rel=0.02)
    assert place == pytest.approx(0.75, abs=0.05)
    assert scene.string.section_at(place).name == "stabiliser"
    assert scene.string.section_at(0.5 * JOINT).name == "collars"


@pytest.mark.parametrize(("boundary", "name"), [(1.5, "stabiliser"), (4.5, "collars")])
def test_a_stress_at_a_change_of_section_is_of_the_thicker_one(scene, boundary, name):
    """The curvature is largest at the boundary, where the pony has the same curvature and a thinner tube."""
    arc, largest, fall = mesh(scene, 200).arc, 1e-3, 60.0  # 1/m, m: the curvature falls linearly to both sides
    away = arc - boundary
    slope = largest * (away - np.sign(away) * away**2 / (2.0 * fall))
    off = largest * (0.5 * away**2 - np.abs(away) ** 3 / (6.0 * fall))
    spin = np.broadcast_to(np.linspace(0.0, 20.0, 80)[:, None], (80, arc.size))
    _, place, _ = fibre_stress(recorded(scene, off, slope, spin), np.arange(80))
    assert place == pytest.approx(boundary, abs=2.0 * INSIDE)
    assert scene.string.section_at(place).name == name


@pytest.mark.parametrize(("twist", "poses", "told"), [(-1e-3, 5, True), (1e-3, 5, False), (-1e-3, 1, False)])
def test_torque_to_the_left_is_told_where_it_lasts(scene, twist, poses, told):
    arc = mesh(scene, 200).arc
    spin = np.zeros((8, arc.size))
    spin[2 : 2 + poses] = 5.0 * twist * arc
    found = list(left_torque(recorded(scene, 0.0 * arc, 0.0 * arc, spin)))
    assert len(found) == told
    if told:
        assert "torque turned joints to the left for 0.4 s, by up to" in found[0]
        assert found[0].endswith("at collars: right-hand joints can back off, at a torque not computed here")


def test_a_string_without_joints_has_no_left_hand_note():
    assert not dt.load_scene("pa6_bench").string.backs_off


def test_a_bending_stress_at_rest_says_that_it_is_of_the_change_alone():
    """In a curved hole at 0 rpm a run printed 1e-05 ksi, as if the string were not bent."""
    still, turning = (
        dt.Simulation("bha_stress", {"rig.rotation.value": speed, "rig.rotation.initial": speed, "rig.duration": "1 s"})
        .run()
        .summary["severity_by_quantity"]["bending_stress"]["why"]
        for speed in ("0 rpm", "120 rpm")
    )
    assert (still, turning) == (STAYS, "")
