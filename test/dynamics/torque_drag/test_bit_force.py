# SPDX-License-Identifier: Apache-2.0
"""Signed force of the bit on the hole beside beams by hand: pendulum, fulcrum, turns; loads of the parts."""

import json
import math

import numpy as np
import pytest
from bent_well import COLLAR, well
from scipy.optimize import fsolve
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.scene import Scene

OUT = Operation("trip out", 0.0, 0.3, 0.0)
ANGLE = math.radians(60.0)
PLAIN = {key: value for key, value in COLLAR.items() if not key.endswith(("strength", "torque"))}
AREA = math.pi / 4.0 * (COLLAR["outer_diameter"] ** 2 - COLLAR["inner_diameter"] ** 2)
STIFFNESS = 206e9 * math.pi / 64.0 * (COLLAR["outer_diameter"] ** 4 - COLLAR["inner_diameter"] ** 4)
ACROSS = 7850.0 * 9.81 * AREA * math.sin(ANGLE)
"""Weight of the collars across the hole [N/m]."""
HOLE = 0.1556
ROOM = HOLE - 0.5 * COLLAR["outer_diameter"]


def straight(*sections: dict[str, object], **changes: object) -> Scene:
    """Collars without friction in a straight hole at 60 deg, or in another hole."""
    own = well(0.0, sections, **changes)
    numerics = own.numerics.model_copy(update={"elements": 600})
    hard = own.effects.model_copy(update={"wall": own.effects.wall.model_copy(update={"stiffness": 1e12})})
    own = own.model_copy(update={"effects": hard})
    if "hole" not in changes:
        own = own.model_copy(update={"hole": own.hole.model_copy(update={"survey": (), "inclination": ANGLE})})
    return own.model_copy(update={"numerics": numerics})


@pytest.mark.slow
def test_a_slick_pendulum_drops_with_half_the_weight_to_its_tangency() -> None:
    """No moment and no slope at the tangency: L^4 = 24 EI r / q, and the bit carries q L / 2."""
    bit = dt.statics(straight(PLAIN | {"length": 120.0}), only=[OUT])["trip out"].contacts[0]
    tangency = (24.0 * STIFFNESS * ROOM / ACROSS) ** 0.25
    assert bit.build == pytest.approx(-0.5 * ACROSS * tangency, rel=0.01)
    assert bit.force == pytest.approx(abs(bit.build), rel=1e-6)
    assert bit.walk == pytest.approx(0.0, abs=1e-3 * bit.force)
    assert bit.lift == pytest.approx(ROOM / tangency + ACROSS * tangency**3 / 24.0 / STIFFNESS, rel=0.01)


def test_a_near_bit_stabiliser_below_a_gap_of_90_ft_builds() -> None:
    """Beam on bit, stabiliser and tangency, by the slopes of its two spans at the stabiliser and at the tangency.

    The string leans to the low side there, so the blades carry at their upper edge.
    """
    at, gauge, blade = 1.2, 0.153, 0.2
    parts = (
        PLAIN | {"length": at - blade}, PLAIN | {"length": blade, "blade_diameter": 2.0 * gauge},
        PLAIN | {"length": 27.4}, PLAIN | {"length": blade, "blade_diameter": 2.0 * gauge}, PLAIN | {"length": 60.0},
    )  # fmt: skip
    bit, near, upper = dt.statics(straight(*parts), only=[OUT])["trip out"].contacts
    room = HOLE - gauge

    def slopes(unknowns: np.ndarray) -> tuple[float, float]:
        """Difference of the slopes at the stabiliser, and the slope at the tangency; moment [N m], span [m]."""
        moment, span = unknowns
        below = room / at - (ACROSS * at**3 / 24.0 + moment * at / 3.0) / STIFFNESS
        above = (ROOM - room) / span + (ACROSS * span**3 / 24.0 + moment * span / 3.0) / STIFFNESS
        flat = (ROOM - room) / span - (ACROSS * span**3 / 24.0 + moment * span / 6.0) / STIFFNESS
        return above - below, flat

    moment, span = fsolve(slopes, (-1e4, 14.0))
    assert span < 20.0  # it lies on the low side before the upper stabiliser
    assert bit.build == pytest.approx(-(0.5 * ACROSS * at + moment / at), rel=0.02)
    assert bit.build > 0.0
    assert near.force > bit.force
    assert math.isnan(near.build)
    assert upper.force > 0.0


@pytest.mark.slow
def test_the_bit_presses_outwards_in_a_turn() -> None:
    """A pinned end wants to go straight: to the left in a turn to the right, as much to the right in the other turn."""
    walks = []
    for turn in (0.4, -0.4):
        stations = [{"depth": depth, "inclination": ANGLE, "azimuth": turn * depth / 120.0} for depth in (0.0, 120.0)]
        hole = well().hole.model_validate({"radius": 0.11, "survey": stations})
        scene = straight(PLAIN | {"length": 120.0}, hole=hole)
        walks.append(dt.statics(scene, only=[OUT])["trip out"].contacts[0].walk)
    assert walks[0] < -1e3
    assert walks[1] == pytest.approx(-walks[0], rel=1e-3)


def test_loads_of_the_parts_add_up(bent_well: Scene, tmp_path) -> None:
    """Tension rises by the weight along the hole, torque by the friction of the parts, side forces by their sum."""
    scene = tmp_path / "well.yaml"
    scene.write_text(bent_well.to_yaml())
    said = CliRunner().invoke(app, ["statics", str(scene), "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.output
    data = json.loads((tmp_path / "out" / "statics.json").read_text())["operations"]
    drill, out = data[-1], data[0]
    assert [part["name"] for part in drill["parts"]] == ["stabiliser", "collar", "pipe"]
    assert [part["distance_from_bit_m"] for part in drill["parts"]] == pytest.approx([0.0, 10.0, 100.0])
    assert drill["parts"][-1]["torque_nm"] == pytest.approx(drill["surface_torque_nm"], rel=0.01)
    assert out["parts"][-1]["tension_n"] == pytest.approx(out["hookload_n"], rel=0.01)
    assert drill["parts"][0]["side_force_n"] == pytest.approx(drill["contacts"][1]["side_force_n"], rel=1e-9)
    levers = (0.154, 0.1016, 0.0635)  # radius on the wall [m], friction 0.25 around the hole
    around = sum(0.25 * lever * part["side_force_n"] for lever, part in zip(levers, drill["parts"], strict=True))
    assert around == pytest.approx(drill["surface_torque_nm"] - drill["bit_torque_nm"], rel=0.01)
    table = " ".join(said.stdout.split())
    assert "build +, drop - right +, left - tilt, up +" in table
    assert "contact moment stress" in table
    assert (tmp_path / "out" / "statics.csv").read_text().splitlines()[0].endswith(",buckling,part")


@pytest.mark.slow
def test_forces_of_a_vertical_plan_are_explained() -> None:
    said = " ".join(CliRunner().invoke(app, ["statics", "wells/vertical_3000"]).stdout.split())
    assert "forces of bit and stabilisers are 0, as the hole is vertical" in said
    assert "build +" not in said
    said = " ".join(CliRunner().invoke(app, ["statics", "wells/s_shaped"]).stdout.split())
    assert "as the hole is vertical" not in said
