"""Critical speeds of a straight assembly between stabilisers beside a beam on its supports, made by hand."""

import math

import pytest

from drill_twin.dynamics.rotordynamics.assembly import assembly_of
from drill_twin.dynamics.rotordynamics.assembly_modes import lateral_modes
from drill_twin.dynamics.torque_drag.operations import Operation
from drill_twin.dynamics.torque_drag.sliding_balance import SlidingBalance
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.dynamics.modes import SET
from drill_twin_evidence.verify.dynamics.supported_beam import Beam, Blade, frequencies
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


def resting(equations, command):
    return SlidingBalance(equations).solve(Operation("turning", command.weight_on_bit, 0.0, command.rotation)).u


@pytest.mark.parametrize("weight_on_bit", [0.0, 150e3], ids=["no load", "150 kN"])
def test_critical_speeds(weight_on_bit):
    sections, blades, begin = [], [], 0.0
    for span in SPANS:
        sections.append({**COLLAR, "length": span})
        begin += span
        if len(blades) < len(SPANS) - 1:
            sections.append({**COLLAR, "length": BLADE, "blade_diameter": 2.0 * GAUGE})
            blades.append(Blade(begin, BLADE, RADIUS - GAUGE))
            begin += BLADE
    scene = quiet_scene(
        {"gravity": {"magnitude": 9.80665}, "wall": {"stiffness": STIFFNESS}}, of=SET, bit_end="pinned",
        inclination=0.5 * math.pi - RISE, radius=RADIUS, sections=sections, weight_on_bit=weight_on_bit, marks=(),
    )  # fmt: skip
    assembly = assembly_of(scene, Command(weight_on_bit, 10.0), FASTEST, resting, finer=2)
    found = lateral_modes(assembly, FASTEST)
    area = math.pi / 4.0 * (COLLAR["outer_diameter"] ** 2 - COLLAR["inner_diameter"] ** 2)
    second = math.pi / 64.0 * (COLLAR["outer_diameter"] ** 4 - COLLAR["inner_diameter"] ** 4)
    mass = COLLAR["density"] * area
    across = 9.80665 * math.cos(RISE)
    beam = Beam(begin, COLLAR["youngs_modulus"] * second, mass, across * mass, weight_on_bit, STIFFNESS, tuple(blades))
    for plane, by_hand in zip(("up-down", "sideways"), frequencies(beam, 5), strict=True):
        own = [mode.eigenvalue.imag for mode in found if mode.plane == plane]
        exact = by_hand[by_hand < FASTEST]
        assert len(own) == exact.size >= 2
        assert own == pytest.approx(exact, rel=0.005)
