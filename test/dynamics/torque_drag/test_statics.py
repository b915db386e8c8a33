# SPDX-License-Identifier: Apache-2.0
"""Loads of a well in the operations of a rig, and the command that prints them."""

import csv
import io
import json
import math
import re

import numpy as np
import pytest
from bent_well import COLLAR, PIPE, well
from typer.testing import CliRunner
from variants import one_of

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, RunError
from drill_twin.dynamics.discretisation.notes import notes_on
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.torque_drag.along_string import hole_and_string
from drill_twin.dynamics.torque_drag.analysis import Statics, steady
from drill_twin.dynamics.torque_drag.sliding_balance import SlidingBalance
from drill_twin.dynamics.torque_drag.soft_string import (
    BucklingState,
    Operation,
    buckling_loads,
    lock_up_weight,
    operations,
    soft_string,
)
from drill_twin.physics.effects.wall_friction import WallFriction
from drill_twin.scene import Scene, well_scenes
from drill_twin.scene.load import override
from drill_twin.studies.statics import loads_table, statics_data


@pytest.fixture(scope="module")
def found(bent_well: Scene) -> Statics:
    return dt.statics(bent_well)


def test_operations_of_a_scene() -> None:
    assert [of.name for of in operations(1e4, 2.0)] == ["trip out", "trip in", "off bottom", "slide", "drill"]
    assert [of.name for of in operations(0.0, 2.0)] == ["trip out", "trip in", "off bottom"]
    assert [of.name for of in operations(1e4, 0.0)] == ["trip out", "trip in", "slide"]


def test_the_hookload_follows_the_operation(found: Statics) -> None:
    out, into, turning = (found[name].hookload for name in ("trip out", "trip in", "off bottom"))
    assert into < turning < out
    assert found["drill"].hookload == pytest.approx(turning - 50e3, rel=5e-3)
    assert found["slide"].hookload < into
    for loads in found.operations:
        assert loads.hookload == pytest.approx(loads.soft.hookload, rel=0.02)
        assert loads.along.tension[-1] == pytest.approx(loads.hookload, rel=0.01)
        assert loads.along.tension[0] == pytest.approx(-loads.operation.weight_on_bit, abs=3e4)


def test_a_reverse_rotation_says_that_right_hand_joints_can_back_off(found: Statics) -> None:
    reverse = dt.statics(well(), {"rig.rotation.value": "-10 rad/s"})
    assert [*reverse.notes] == ["off bottom", "drill"]
    assert reverse.notes["drill"].startswith("drill: turns to the left: right-hand joints can back off")
    assert not found.notes
    (note,) = (note for note in notes_on(reverse.scene) if "to the left" in note)
    assert note.startswith("`rig.rotation` is below 0, to the left: right-hand joints can back off")
    assert not [note for note in notes_on(found.scene) if "to the left" in note]


def test_the_weight_of_the_string(found: Statics) -> None:
    """Rotation takes the friction off the axial force: the hookload is the weight along the hole."""
    area = [math.pi / 4.0 * (of["outer_diameter"] ** 2 - of["inner_diameter"] ** 2) for of in (COLLAR, PIPE)]
    bow = 400.0 / math.radians(60.0) * math.sin(math.radians(60.0))
    height = 200.0 + bow + 0.5 * 300.0
    expected = 7850.0 * 9.81 * (area[1] * height + area[0] * 50.0)
    assert found["off bottom"].hookload == pytest.approx(expected, rel=2e-3)


def test_torque_only_when_rotating(found: Statics) -> None:
    assert found["drill"].surface_torque == pytest.approx(found["drill"].soft.surface_torque, rel=0.05)
    assert found["off bottom"].twist > 0.0
    for name in ("trip out", "trip in", "slide"):
        assert abs(found[name].surface_torque) < 1.0


def test_a_string_that_turns_backwards_has_the_opposite_torque(found: Statics) -> None:
    elements = hole_and_string(found.scene, SlidingBalance(EquationsOfMotion(steady(found.scene))).equations.model)
    for operation in (found[name].operation for name in ("off bottom", "drill")):
        forward = soft_string(elements, operation, 4e3)
        reverse = soft_string(elements, operation._replace(rotation=-operation.rotation), -4e3)
        assert reverse.torque == pytest.approx(-forward.torque, rel=1e-12)
        assert reverse.tension == pytest.approx(forward.tension, rel=1e-12)
    turning = found["off bottom"].operation
    backwards = dt.statics(found.scene, only=[turning._replace(rotation=-turning.rotation)])["off bottom"]
    assert backwards.soft.surface_torque == pytest.approx(-found["off bottom"].soft.surface_torque, rel=1e-9)
    assert backwards.surface_torque == pytest.approx(backwards.soft.surface_torque, rel=0.05)


def test_an_unknown_operation_is_told_with_the_known_ones(found: Statics) -> None:
    with pytest.raises(ArgumentError, match=r'one of trip out, trip in, .* "tripout", did you mean "trip out"') as told:
        found["tripout"]
    assert "off bottom, slide, drill" in str(told.value)


def test_a_string_that_locks_has_no_load(found: Statics) -> None:
    """Friction of 3 holds the string when it slides in: the bound of its compression is no load."""
    elements = hole_and_string(found.scene, SlidingBalance(EquationsOfMotion(steady(found.scene))).equations.model)
    slide = found["slide"]
    locked = soft_string(elements._replace(friction=np.full_like(elements.friction, 3.0)), slide.operation)
    assert math.isnan(locked.hookload)
    assert math.isfinite(locked.tension[0])
    assert np.nanmin(locked.tension) > -1e8
    shown = Statics(found.scene, (found["trip out"], slide._replace(soft=locked)))
    row = loads_table(shown).text().splitlines()
    assert [line.split()[2] for line in row if line.startswith("slide ")] == ["locked"]
    assert "locked: friction holds the string" in " ".join(" ".join(row).split())
    assert "locked" not in loads_table(found).text()
    assert statics_data(shown)["operations"][1]["hookload_soft_string_n"] is None


def test_rounding_is_printed_as_zero(found: Statics) -> None:
    """Without rotation each torque and twist is 0, beside rounding of 1e-16 N m."""
    still = Statics(found.scene, tuple(found[name] for name in ("trip out", "trip in", "slide")))
    assert 0.0 < max(abs(loads.surface_torque) for loads in still.operations) < 1e-9
    lines = [line.split() for line in loads_table(still).text().splitlines()]
    rows = [line for line in lines if line[:1] == ["slide"] or line[:2] in (["trip", "out"], ["trip", "in"])]
    assert len(rows) == 3
    assert [(row[-5], row[-1]) for row in rows] == [("0", "0")] * 3


def test_neutral_point_and_stretch(found: Statics) -> None:
    assert found["trip out"].neutral_point == 0.0
    weight = 7850.0 * 9.81 * math.pi / 4.0 * (0.2032**2 - 0.0714**2) * 0.5
    assert found["drill"].neutral_point == pytest.approx(50e3 / weight, rel=0.05)
    assert found["trip in"].stretch < found["off bottom"].stretch < found["trip out"].stretch


def test_margins(found: Statics) -> None:
    out, drill = found["trip out"], found["drill"]
    assert out.margins == (math.inf, math.inf)
    assert out.worst_state is BucklingState.STRAIGHT
    assert math.isnan(out.lock_up)
    assert drill.yield_margin == pytest.approx(724e6 / drill.along.stress.max())
    strength = np.where(drill.along.depth > 900.0, 60e3, 30e3)
    assert drill.make_up_margin == pytest.approx(float((strength / np.abs(drill.along.torque)).min()))
    assert drill.margins[1] == pytest.approx(math.sqrt(2.0) * drill.margins[0])


def test_bit_and_stabiliser_carry_the_collars(found: Statics) -> None:
    bit, stabiliser = found["off bottom"].contacts
    assert (bit.name, stabiliser.name) == ("bit", "stabiliser")
    assert stabiliser.distance_from_bit == 5.0
    assert stabiliser.force > 5e3
    assert 0.0 < bit.tilt < math.radians(1.0)


def test_a_string_without_weight_is_told(bent_well: Scene) -> None:
    trip = Operation("trip out", 0.0, 0.3, 0.0)
    with pytest.raises(RunError, match=r'operation "trip out", found none: .*weight has no .*list effects\.gravity'):
        dt.statics(bent_well, {"effects.gravity.magnitude": 0.0, "numerics.elements": 20}, only=[trip])


def test_the_possible_operations_of_a_level_well_are_printed(tmp_path) -> None:
    """Friction holds the string as it slides in: tripping in stops at a depth, and nothing else is lost."""
    leans = ((0.0, 0.0), (150.0, 0.0), (450.0, 90.0), (1000.0, 90.0))
    survey = [{"depth": depth, "inclination": math.radians(angle), "azimuth": 0.5} for depth, angle in leans]
    scene = well(0.6)
    hole = type(scene.hole).model_validate({"radius": 0.1556, "survey": survey})
    weight = scene.rig.weight_on_bit.model_copy(update={"value": 5e3})
    rig = scene.rig.model_copy(update={"weight_on_bit": weight})
    coarse = scene.numerics.model_copy(update={"elements": 100})
    found = dt.statics(scene.model_copy(update={"hole": hole, "rig": rig, "numerics": coarse}))
    assert [loads.operation.name for loads in found.operations] == ["trip out", "off bottom", "drill"]
    assert [*found.notes] == ["trip in", "slide"]
    stop = float(re.search(r"with the bit from (\d+) m on", found.notes["trip in"])[1])
    trip = operations(0.0, 0.0)[1]
    solver = SlidingBalance(EquationsOfMotion(steady(found.scene)))
    loads = [soft_string(hole_and_string(found.scene, solver.equations.model, stop + by), trip).hookload
             for by in (-20.0, 0.0)]  # fmt: skip
    assert loads[0] > 0.0 > loads[1]
    with pytest.raises(RunError, match="friction holds its pipe"):
        found["slide"]
    pushed = dt.statics(found.scene, {"effects.wall_friction.coefficient": 0.45}, only=[trip])
    assert pushed["trip in"].hookload < 0.0
    assert pushed.notes["trip in"].startswith("trip in: the top has to push, its hookload is below 0: by the soft")
    (tmp_path / "level.yaml").write_text(found.scene.to_yaml())
    said = CliRunner().invoke(app, ["statics", str(tmp_path / "level.yaml"), "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.output
    assert "drill " in said.stdout
    assert f"with the bit from {stop:g} m on" in " ".join(said.stdout.split())
    assert [*json.loads((tmp_path / "out" / "statics.json").read_text())["notes"]] == ["trip in", "slide"]


@pytest.mark.parametrize("weight", ["170", "200"])
def test_weight_that_buckles_the_pipe_is_told(bent_well: Scene, weight: str) -> None:
    """Below and above the weight that the string takes without a push, both limits are named."""
    slide = Operation("slide", 1e3 * float(weight), -5e-3, 0.0)
    with pytest.raises(RunError, match=rf"none at {weight} kN: .* buckles from 155\.7 kN on, .*takes at most 188 kN"):
        dt.statics(bent_well, only=[slide])


def test_friction_by_depth(bent_well: Scene) -> None:
    """Torque of a rotating string in a hole at 60 deg throughout: mu w sin(60 deg) r over each interval."""
    friction = {"coefficient": 0.3, "intervals": [{"top": 0.0, "bottom": 400.0, "coefficient": 0.1}]}
    scene = bent_well.model_copy(
        update={
            "hole": bent_well.hole.model_copy(update={"survey": (), "inclination": math.radians(60.0)}),
            "string": bent_well.string.model_copy(update={"sections": bent_well.string.sections[2:]}),
            "effects": bent_well.effects.model_copy(update={"wall_friction": WallFriction(**friction)}),
        }
    )
    loads = dt.statics(scene)["off bottom"]
    area = math.pi / 4.0 * (PIPE["outer_diameter"] ** 2 - PIPE["inner_diameter"] ** 2)
    across = area * 7850.0 * 9.81 * math.sin(math.radians(60.0))
    expected = (0.1 * 400.0 + 0.3 * (scene.length - 400.0)) * across * 0.5 * PIPE["outer_diameter"]
    assert loads.soft.surface_torque == pytest.approx(expected, rel=5e-3)
    assert loads.surface_torque == pytest.approx(expected, rel=0.06)  # off the wall near both ends


def test_a_soft_string_does_not_depend_on_where_a_bend_begins_in_an_element() -> None:
    """Tension lifts the string to the high side in a drop and gravity pulls it down below: forces do not add up."""
    leans = ((0.0, 0.0), (203.0, 0.0), (251.0, 12.0), (352.0, 3.0), (1000.0, 3.0))
    survey = [{"depth": depth, "inclination": math.radians(angle), "azimuth": 0.5} for depth, angle in leans]
    turning, found = operations(0.0, 10.0)[2], []
    for elements in (100, 1500):
        own = override(well(), {"numerics.elements": elements})
        own = own.model_copy(update={"hole": type(own.hole).model_validate({"radius": 0.1556, "survey": survey})})
        equations = EquationsOfMotion(steady(own))
        found.append(soft_string(hole_and_string(equations.scene, equations.model), turning))
    assert found[0].surface_torque == pytest.approx(found[1].surface_torque, rel=2e-3)
    assert found[0].hookload == pytest.approx(found[1].hookload, rel=1e-5)


def test_lock_up_of_a_straight_hole() -> None:
    """Without buckling the weight that slides in is w L (cos(alpha) - mu sin(alpha))."""
    scene = well()
    level = scene.hole.model_copy(update={"survey": (), "inclination": 1.0, "radius": 0.11})
    stiff = tuple(part.model_copy(update={"youngs_modulus": 1e13}) for part in scene.string.sections[1:])
    string = scene.string.model_copy(update={"sections": stiff})
    own = scene.model_copy(update={"hole": level, "string": string})
    solver = SlidingBalance(EquationsOfMotion(steady(own)))
    elements = hole_and_string(solver.equations.scene, solver.equations.model)
    slide = Operation("slide", 1.0, -0.01, 0.0)
    weight = sum(part.mass_per_length * part.length for part in stiff) * 9.81
    exact = weight * (math.cos(1.0) - 0.25 * math.sin(1.0))
    assert lock_up_weight(elements, slide) == pytest.approx(exact, rel=1e-4)
    assert soft_string(elements, slide._replace(weight_on_bit=exact)).hookload == pytest.approx(0.0, abs=1e-6 * exact)


def test_published_buckling_loads() -> None:
    """5 in. pipe of 19.5 lb/ft in a 12 1/4 in. hole; the helical load is between those of Chen and Mitchell."""
    bending, weight, clearance = 1.22e6, 250.0, 0.0921
    loads = buckling_loads(*(np.array([value]) for value in (bending, weight, weight, clearance)))
    snaking = 2.0 * math.sqrt(bending * weight / clearance)
    assert loads.sinusoidal[0] == pytest.approx(snaking, rel=1e-12)
    assert 2.0 * math.sqrt(2.0) * snaking / 2.0 <= loads.helical[0] * (1 + 1e-12) <= 2.0 * math.sqrt(2.0) * snaking
    shares = -snaking * np.array([0.99, 1.01, 1.5, 2.9])
    assert [int(loads.states(np.array([share]))[0]) for share in shares] == [0, 1, 2, 3]
    vertical = buckling_loads(*(np.array([value]) for value in (bending, 0.0, weight, clearance)))
    assert vertical.sinusoidal[0] == pytest.approx(1.94 * (bending * weight**2) ** (1.0 / 3.0))
    assert vertical.helical[0] == pytest.approx(5.55 * (bending * weight**2) ** (1.0 / 3.0))


@pytest.mark.slow
def test_the_command(bent_well: Scene, found: Statics, tmp_path) -> None:
    scene = tmp_path / "well.yaml"
    scene.write_text(bent_well.to_yaml())
    said = CliRunner().invoke(app, ["statics", str(scene), "--units", "field", "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.output
    assert "klbf" in said.stdout
    assert f"{found['trip out'].hookload / 4448.2216152605:.4g}" in said.stdout
    data = json.loads((tmp_path / "out" / "statics.json").read_text())
    assert data["operations"][0]["hookload_n"] == pytest.approx(found["trip out"].hookload, rel=1e-9)
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out" / "statics.csv").read_text())))
    assert len(rows) == 5 * 200
    assert float(rows[0]["measured depth [m]"]) < float(rows[1]["measured depth [m]"])
    assert (tmp_path / "out" / "statics.png").stat().st_size > 30_000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rop", "-18 m/h"], "--rop: expected a speed above 0"),
        (["--trip-speed", "fast"], "--trip-speed: expected a speed"),
        (["--without", "wall"], "--without wall: expected no effect that needs it, found wall_friction"),
    ],
)
def test_the_command_refuses_what_has_no_balance(arguments: list[str], words: str) -> None:
    said = CliRunner().invoke(app, ["statics", "wells/s_shaped", *arguments])
    assert words in str(said.exception)


@pytest.mark.parametrize("name", one_of(3, well_scenes()))
def test_shipped_wells_have_a_balance_in_each_operation(name: str) -> None:
    found = dt.statics(name)
    assert len(found.operations) == 5
    for loads in found.operations:
        assert loads.hookload == pytest.approx(loads.soft.hookload, rel=0.02, abs=0.5)
        assert loads.surface_torque == pytest.approx(
            loads.soft.surface_torque, rel=0.08, abs=0.05 * found["drill"].surface_torque
        )


@pytest.mark.slow
def test_a_level_rotor_is_balanced_by_its_weight_across() -> None:
    """None of its weight is along the hole."""
    loads = dt.statics("rotor_kit")["trip out"]
    assert abs(loads.hookload) < 1e-4
    assert loads.balance.u[:, 0].max() == pytest.approx(3.12e-4, rel=0.01)  # Euler and Bernoulli's beam of 56 elements


def test_a_balance_on_the_axis_past_a_buckling_load_is_told() -> None:
    said = CliRunner().invoke(app, ["statics", "wells/vertical_3000", "--wob", "400 kN"]).stdout
    assert "slide, drill: past a buckling load, but in balance on the axis" in " ".join(said.split())
    assert (
        "past a buckling load"
        not in CliRunner().invoke(app, ["statics", "wells/vertical_3000", "--wob", "9 kN"]).stdout
    )
