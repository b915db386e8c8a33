"""Critical speeds of an assembly, between stabilisers and on the low side of a well, beside a beam made by hand."""

import math

import pytest

from drill_twin.api import rotordynamics
from drill_twin.dynamics.rotordynamics.assembly import assembly_of
from drill_twin.dynamics.rotordynamics.assembly_modes import LIGHT, lateral_modes
from drill_twin.dynamics.torque_drag.sliding_balance import SlidingBalance
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.dynamics.modes import SET
from drill_twin_evidence.verify.dynamics.supported_beam import Beam, Piece, modes_near
from drill_twin_evidence.verify.scenes import quiet_scene

COLLAR = {"outer_diameter": 0.2032, "inner_diameter": 0.0714375, "youngs_modulus": 206e9, "poisson_ratio": 0.3,
          "density": 7850.0}  # fmt: skip
RADIUS, GAUGE, BLADE = 0.155575, 0.154, 0.5
"""Of the hole, over the blades, and the length of a stabiliser [m]."""
SPANS = (2.0, 9.5, 10.0, 8.0)
"""Between stabilisers, from the bit up; the last is clamped at the top [m]."""
STIFFNESS, FASTEST = 1e10, 60.0
RISE = 0.05
"""Of the hole [rad]: its weight along the hole is the only load of a string without weight on bit."""
STEEL, GRAVITY = 7850.0, 9.81
ABOVE = 150.0
"""Pipe above an assembly in which motion is absorbed [m]."""


def resting(equations, command):
    return SlidingBalance(equations).solve(Operation("turning", command.weight_on_bit, 0.0, command.rotation)).u


def tube(outer, inner):
    """Area [m2] and its second moment [m4]."""
    return math.pi / 4.0 * (outer**2 - inner**2), math.pi / 64.0 * (outer**4 - inner**4)


@pytest.mark.parametrize("weight_on_bit", [0.0, 150e3], ids=["no load", "150 kN"])
def test_stabilised(weight_on_bit):
    sections, pieces = [], []
    area, second = tube(COLLAR["outer_diameter"], COLLAR["inner_diameter"])
    mass = COLLAR["density"] * area
    across, along = 9.80665 * mass * math.cos(RISE), 9.80665 * mass * math.sin(RISE)
    for i, span in enumerate(SPANS):
        for length, blade in ((span, None), (BLADE, 2.0 * GAUGE))[: 1 if i == len(SPANS) - 1 else 2]:
            sections.append({**COLLAR, "length": length} | ({"blade_diameter": blade} if blade else {}))
            clearance = RADIUS - 0.5 * (blade or COLLAR["outer_diameter"])
            pieces.append(Piece(length, COLLAR["youngs_modulus"] * second, mass, across, along, clearance))
    scene = quiet_scene(
        {"gravity": {"magnitude": 9.80665}, "wall": {"stiffness": STIFFNESS}}, of=SET, bit_end="pinned",
        inclination=0.5 * math.pi - RISE, radius=RADIUS, sections=sections, weight_on_bit=weight_on_bit, marks=(),
    )  # fmt: skip
    assembly = assembly_of(scene, Command(weight_on_bit, 10.0), FASTEST, resting, finer=2)
    found = [mode for mode, _ in lateral_modes(assembly, assembly.pencil(10.0, FASTEST), FASTEST)]
    by_hand = modes_near(Beam(tuple(pieces), weight_on_bit, STIFFNESS), [10.0, 40.0])
    for plane, up_down in (("up-down", True), ("sideways", False)):
        own = [mode.eigenvalue.imag for mode in found if mode.plane == plane]
        exact = [
            mode.eigenvalue.imag
            for mode in by_hand
            if 0.0 < mode.eigenvalue.imag < FASTEST and (mode.up_down > 0.5) == up_down
        ]
        assert len(own) == len(exact) >= 2
        assert own == pytest.approx(exact, rel=0.005)


def on_the_low_side(scene, pipe):
    """The lowest part of a well's string up to a length of its pipe, in mud, in the straight end of the hole."""
    last, mud = scene.hole.survey[-1].inclination, scene.effects.mud.density
    pieces = []
    for section in scene.string.sections:
        area, second = tube(section.outer_diameter, section.inner_diameter)
        own = section.adjusted_mass or STEEL * area
        buoyant = own * (1.0 - mud / STEEL) * GRAVITY
        displaced = mud * math.pi / 4.0 * (section.outer_diameter**2 + section.inner_diameter**2)
        widest = max(section.outer_diameter, section.blade_diameter or 0.0)
        length = min(section.length, pipe)
        pieces.append(
            Piece(length, 206.8e9 * second, own + displaced, buoyant * math.sin(last), buoyant * math.cos(last),
                  scene.hole.radius - 0.5 * widest)
        )  # fmt: skip
        if section.name == "drill pipe":
            return tuple(pieces)
    raise AssertionError


@pytest.mark.parametrize("name", ["s_shaped", pytest.param("extended_reach", marks=pytest.mark.long)])
def test_well(name):
    """All critical speeds that `modes` lists, and no others, with the contact that holds the string: within 1 %."""
    open_fluid = {"added_mass.confined": "false", "effects.viscous_drag": "off"}  # as the beam by hand has it
    scene = load_scene(f"wells/{name}", overrides={"wall_friction.coefficient": 0.3} | open_fluid)
    table = rotordynamics.modes(scene)
    assembly, fastest = table.assembly.extent.assembly, 2.0 * scene.rig.rotation.value
    beam = Beam(on_the_low_side(scene, ABOVE), scene.rig.weight_on_bit.value, scene.effects.wall.stiffness,
                scene.effects.wall_friction.coefficient, assembly, 0.5 * fastest)  # fmt: skip
    by_hand = [
        mode.eigenvalue.imag
        for mode in modes_near(beam, [fastest * share for share in (0.1, 0.18, 0.22, 0.4, 0.6, 0.8, 0.95)])
        if 0.0 < mode.eigenvalue.imag < fastest
        and -mode.eigenvalue.real < LIGHT * abs(mode.eigenvalue)
        and mode.at < assembly
    ]
    assert [mode.eigenvalue.imag for mode in table.of("lateral")] == pytest.approx(by_hand, rel=0.01)
