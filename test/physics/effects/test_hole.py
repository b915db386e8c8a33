# SPDX-License-Identifier: Apache-2.0
"""The hole: curved by a survey, of a radius that changes with depth; and what of the string meets it."""

import numpy as np
import pytest
from hole_scenes import ON_THE_WALL, SETTLING, bend, with_parts
from rod_scenes import DIAMETER, EA, EI, LINE_MASS

from drill_twin.dynamics.twin.frame import Frame
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.scenes import QUIET

CLEARANCE = 0.01
RADIUS = CLEARANCE + DIAMETER / 2
SETTLED = ON_THE_WALL | SETTLING
WEIGHT = LINE_MASS * 9.81
MIDDLE = [{"name": "middle", "distance_from_bit": 10.0, "on": "centre"}]


def settled(scene: Scene, weight_on_bit: float = 0.0, seconds: float = 3.0, still: float = 1e-4) -> tuple[Twin, Frame]:
    twin = Twin(scene)
    for _ in range(round(seconds / 0.02)):
        frame = twin.advance(Command(weight_on_bit=weight_on_bit, rotation=0.0), 0.02)
    assert np.abs(frame.velocities).max() < still, "the string must be at rest"
    return twin, frame


def pulled(**hole: float) -> tuple[Twin, Frame]:
    """A weightless string of 20 m pulled with 20 N through a bend of 40 m."""
    scene = with_parts(
        effects=SETTLED, length=20.0, elements=80, step=2e-3, weight_on_bit=-20.0, marks=MIDDLE,
        hole=bend(40.0, 20.0, hole=RADIUS, **hole),
    )  # fmt: skip
    return settled(scene, -20.0)


def test_a_pulled_string_presses_on_the_inside_of_a_bend() -> None:
    """N = T / R per length of string (soft string), at the radius where it lies, within 1e-3.

    The mark tells it in the frame of the hole at its depth: off the axis by the clearance, towards the centre of
    curvature (a hole that starts plumb builds towards -x), 10 m down the hole; nothing is twisted.
    """
    twin, frame = pulled()
    inside = slice(20, -20)
    assert frame.wall_force[inside] / 0.25 == pytest.approx(20.0 / (40.0 - CLEARANCE), rel=1e-3)
    penetration = (0.5 / 1e7) ** (2.0 / 3.0)
    assert frame.marks.centre[0, :2] == pytest.approx([-CLEARANCE - penetration, 0.0], abs=1e-6)
    assert frame.marks.centre[0, 2] == pytest.approx(-10.0 * 40.0 / (40.0 - CLEARANCE), abs=1e-3)
    assert penetration < frame.wall_depth < 3.0 * penetration
    assert abs(frame.rig.top_drive_torque) < 1e-9
    turn = 20.0 / 40.0
    place, tangent = frame.positions, frame.tangents
    assert frame.rig.hookload == pytest.approx(20.0, rel=1e-4)
    assert place[0, [0, 2]] == pytest.approx([-40.0 * (1 - np.cos(turn)), -40.0 * np.sin(turn)], abs=1e-2)
    assert tangent[0] == pytest.approx([np.sin(turn), 0.0, np.cos(turn)], abs=1e-9)
    assert twin.elements == 80


def test_no_azimuth_is_special() -> None:
    """Turning the whole survey about the plumb line changes nothing that is told in the hole's frame."""
    _, north = pulled(azimuth=0.0)
    _, other = pulled(azimuth=2.1)
    assert other.positions == pytest.approx(north.positions, abs=1e-9)
    assert other.wall_force == pytest.approx(north.wall_force, abs=1e-7)


def test_rotation_in_a_bend_needs_no_torque_without_friction() -> None:
    """The spin runs through a bend in three dimensions without untwisting or winding it."""
    stations = [
        {"depth": 0.0, "inclination": 0.5, "azimuth": 0.0},
        {"depth": 10.0, "inclination": 0.7, "azimuth": 0.3},
        {"depth": 20.0, "inclination": 0.8, "azimuth": 0.9},
    ]
    scene = with_parts(
        effects=SETTLED, length=20.0, elements=80, step=2e-3, weight_on_bit=-20.0, marks=MIDDLE,
        hole={"radius": RADIUS, "survey": stations},
    )  # fmt: skip
    twin = Twin(scene)
    first = twin.advance(Command(weight_on_bit=-20.0, rotation=0.0), 0.02)
    assert abs(first.rig.top_drive_torque) < 1e-4, "it starts untwisted"
    for k in range(250):
        frame = twin.advance(Command(weight_on_bit=-20.0, rotation=5.0 * min((k + 1) / 50.0, 1.0)), 0.02)
    # what is left brakes the bending of the turning material: c = EI eta kappa^2 per length, and drag on the spin is 0
    axis = twin.model.wellbore.axis
    assert axis is not None
    losses = float(np.sum(np.repeat(twin.rod.length / 2.0, 2) * EI * 0.02 * axis.curvature**2)) * 5.0
    assert frame.rig.top_drive_torque == pytest.approx(losses, rel=0.1)
    assert frame.marks.spin_rate[0] == pytest.approx(5.0, rel=1e-3)


def lying(**parts: object) -> tuple[Twin, Frame]:
    """A string of 20 m at rest in a horizontal hole."""
    options = {"radius": RADIUS, "inclination": np.pi / 2} | dict(parts.pop("hole", {}))
    scene = with_parts(
        effects=SETTLED | {"gravity": {"magnitude": 9.81}}, length=20.0, elements=80, step=2e-3, hole=options, **parts
    )
    return settled(scene)


def test_a_washout_lets_the_string_sag() -> None:
    """Where the hole is wider the string lies deeper, by the difference of the radii; at the end of it, it does not."""
    marks = [{"name": f"at_{place}", "distance_from_bit": float(place), "on": "centre"} for place in (3, 10, 17)]
    wide = {"top": 6.0, "bottom": 14.0, "radius": RADIUS + 0.02}
    _, frame = lying(hole={"intervals": [wide]}, marks=marks)
    penetration = (WEIGHT / 1e7) ** (2.0 / 3.0)
    assert frame.marks.centre[:, 0] - penetration == pytest.approx([0.01, 0.03, 0.01], abs=2e-5)


def test_blades_hold_the_string_off_the_wall() -> None:
    """Between two stabilisers that fill the hole but for 1 mm the string is off the wall; marks sit on the blades."""
    blade = {"length": 0.5, "blade_diameter": 2 * (RADIUS - 1e-3)}
    sections = [{"length": 9.0}, blade, {"length": 1.0}, blade, {"length": 9.0}]
    marks = [
        {"name": "blade", "distance_from_bit": 9.05, "on": "wall"},
        {"name": "between", "distance_from_bit": 10.0, "on": "centre"},
    ]
    _, frame = lying(sections=sections, marks=marks)
    assert frame.marks.centre[0, 0] == pytest.approx(1e-3, abs=3e-4)  # on the edge of the blade
    # between a beam held at its ends and one that is free to tilt there
    sag = frame.marks.centre[1, 0] - frame.marks.centre[0, 0]
    assert WEIGHT / (384.0 * EI) < sag < 5.0 * WEIGHT / (384.0 * EI)
    arm = frame.marks.position[0] - frame.marks.centre[0]
    assert np.linalg.norm(arm) == pytest.approx(RADIUS - 1e-3, rel=1e-9)
    assert frame.wall_force.sum() == pytest.approx(20.0 * WEIGHT, rel=0.15)


def test_tool_joints_carry_the_string() -> None:
    """A string with joints half as thick again lies on them, and weighs what pipe and joints weigh."""
    joints = {"spacing": 1.0, "length": 0.1, "diameter": 1.5 * DIAMETER}
    marks = [
        {"name": "joint", "distance_from_bit": 9.95, "on": "wall"},
        {"name": "pipe", "distance_from_bit": 10.45, "on": "wall"},
    ]
    twin, frame = lying(section={"joints": joints}, marks=marks)
    assert twin.scene.outer_radius_at(9.95) == 0.75 * DIAMETER
    assert twin.scene.outer_radius_at(10.45) == 0.5 * DIAMETER
    mass = float(np.sum(twin.rod.line_mass * twin.rod.length))
    assert mass == pytest.approx(LINE_MASS * (18.0 + 2.0 * 1.5**2), rel=1e-12)
    lift = CLEARANCE - 0.25 * DIAMETER
    assert frame.marks.centre[0, 0] == pytest.approx(lift, abs=4e-4)
    on_pipe = np.abs(np.mod(twin.rod.arc, 1.0) - 0.45) < 0.2
    assert frame.wall_force[on_pipe].sum() == 0.0


def test_the_wall_that_was_not_listed_is_told() -> None:
    """Without `wall` the frame still says how far the string is outside of the hole, and where."""
    effects = QUIET | {
        "gravity": {"magnitude": 0.02}, "drag": {"linear": 0.3}, "internal_damping": SETTLING["internal_damping"],
    }  # fmt: skip
    options = {"bit_end": "free", "length": 5.0, "effects": effects, "inclination": np.pi / 2, "form": "lateral"}
    sag = LINE_MASS * 0.02 * 5.0**4 / (8.0 * EI)
    for radius, outside in ((0.02, True), (1.0, False)):
        twin = Twin(with_parts(**options, radius=radius))
        for _ in range(200):
            frame = twin.advance(Command(weight_on_bit=0.0, rotation=0.0), 0.1)
        assert frame.wall_depth == pytest.approx(sag - (radius - DIAMETER / 2), rel=0.03)
        assert (frame.wall_depth > 0.0) == outside
        assert frame.wall_depth_at < 0.1
        assert not frame.wall_force.any()


def test_a_pull_stretches_a_string_of_two_sections() -> None:
    """F (L_1 / EA_1 + L_2 / EA_2), within 0.3 %: at the change the strain is shared, an error of first order in h."""
    sections = [{"length": 2.5}, {"length": 2.5, "outer_diameter": 2 * DIAMETER}]
    scene = with_parts(
        effects=SETTLED, length=5.0, elements=64, step=2e-3, radius=1.0, weight_on_bit=-100.0, sections=sections
    )
    _, frame = settled(scene, -100.0, seconds=2.0, still=1e-3)
    exact = 100.0 * 2.5 / EA * (1.0 + 0.25)
    assert -5.0 - frame.positions[0, 2] == pytest.approx(exact, rel=3e-3)
