# SPDX-License-Identifier: Apache-2.0
"""The bit's own end: a stabiliser that leaves it some room, and forces across it."""

import numpy as np
import pytest
from rod_scenes import EI, LENGTH, rod_scene

from drill_twin.dynamics.twin.frame import Frame
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command

SPRING = 3.0 * EI / LENGTH**3  # of the rod's end, held at the top [N/m]
HOLE, GAUGE = 0.1, 0.16
ROOM = HOLE - GAUGE / 2
LOSSY = {
    "drag": {"linear": 0.4},
    "internal_damping": {"bending_time": 0.05, "stretch_time": 2e-3, "torsion_time": 2e-3},
}


def settled(side: dict, stabiliser: dict, turn: float = 0.0, then: float | None = None, seconds: float = 25.0) -> Frame:
    effects = LOSSY | {"bit_side_force": side, "bit_stabiliser": {"gauge": GAUGE, "stiffness": 1e4} | stabiliser}
    twin = Twin(rod_scene(effects=effects, bit_end="stabilised", radius=HOLE, elements=12, step=0.01, frame_rate=10.0))
    for k in range(round(10 * seconds)):
        speed = turn if then is None or k < 50 else then
        frame = twin.advance(Command(0.0, speed * min((k + 1) / 10.0, 1.0)), 0.1)
    return frame


def test_within_its_room_the_bit_is_free():
    """A cantilever: F L^3 / (3 EI) aside, as long as that is less than the clearance at the gauge."""
    place = settled({"force": 0.8 * SPRING * ROOM}, {}).positions[0]
    assert place[:2] == pytest.approx([0.8 * ROOM, 0.0], rel=1e-3, abs=1e-9)


def test_the_wall_stops_the_bit_at_its_gauge():
    """Beyond, the wall takes what bending does not: penetration (F - k c) / (K + k)."""
    place = settled({"force": 5.0 * SPRING * ROOM, "angle": 1.0}, {"stiffness": 10.0}).positions[0]
    depth = 4.0 * SPRING * ROOM / (10.0 + SPRING)
    assert np.hypot(*place[:2]) == pytest.approx(ROOM + depth, rel=1e-3)
    assert np.arctan2(place[1], place[0]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_friction_moves_the_turning_bit_aside_and_takes_torque(speed):
    """Balance on the wall: F cos(phi) = N + k r and F sin(phi) = k r eta Omega - mu N; the drive pays mu N R.

    The damping of the material, which turns under its bend, pushes it forward (Genta 2005), friction pushes it back.
    """
    force, mu = 5.0 * SPRING * ROOM, 0.3
    frame = settled({"force": force}, {"friction": mu}, turn=speed)
    radius, angle = np.hypot(*frame.positions[0, :2]), np.arctan2(frame.positions[0, 1], frame.positions[0, 0])
    normal = force * np.cos(angle) - SPRING * radius
    assert radius == pytest.approx(ROOM, rel=0.01)
    forward = SPRING * radius * LOSSY["internal_damping"]["bending_time"] * speed
    assert np.sin(angle) == pytest.approx((forward - np.sign(speed) * mu * normal) / force, rel=5e-3)
    # the drive also pays for what the damping of the material takes: its couple is forward times r
    torque = np.sign(speed) * mu * normal * GAUGE / 2 + forward * radius
    assert frame.rig.top_drive_torque == pytest.approx(torque, rel=0.01)


def test_newton_does_not_alternate_where_the_blades_rub_and_strike():
    """A turning bit that strikes the wall at friction 1: two iterations a step, no step halved (13 and 845 once)."""
    effects = LOSSY | {
        "bit_side_force": {"force": 5.0 * SPRING * ROOM},
        "bit_stabiliser": {"gauge": GAUGE, "stiffness": 1e5, "friction": 1.0},
    }
    twin = Twin(rod_scene(effects=effects, bit_end="stabilised", radius=HOLE, elements=12, step=0.01, frame_rate=10.0))
    frames = [twin.advance(Command(0.0, 20.0 * min((k + 1) / 10.0, 1.0)), 0.1).stats for k in range(50)]
    steps = sum(frame.steps for frame in frames)
    assert sum(frame.iterations for frame in frames) < 2.5 * steps
    assert sum(frame.cut_steps for frame in frames) < 0.01 * steps


def test_its_length_resists_tilting():
    """A moment M tilts the end by M L / (EI + k L) against a tilt stiffness k."""
    tangent = settled({"moment": 0.02}, {"tilt_stiffness": 2.0}).tangents[0]
    assert -tangent[0] == pytest.approx(0.02 * LENGTH / (EI + 2.0 * LENGTH), rel=1e-3)


def test_a_bent_housing_turns_with_the_bit_and_a_pad_does_not():
    """After the top has turned by 2 rad the force points where the bit does, or where it always did."""
    for turns, angle in (("with_bit", 2.3), ("with_hole", 0.3)):
        side = {"force": 0.5 * SPRING * ROOM, "angle": 0.3, "turns": turns}
        frame = settled(side, {}, turn=0.4, then=0.0, seconds=30.0)
        assert frame.spin[0] == pytest.approx(0.4 * 5.0, abs=0.25)
        turned = frame.spin[0] if turns == "with_bit" else 0.0
        assert np.arctan2(frame.positions[0, 1], frame.positions[0, 0]) == pytest.approx(0.3 + turned, abs=1e-3), angle
