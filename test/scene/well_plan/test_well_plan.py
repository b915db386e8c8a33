# SPDX-License-Identifier: Apache-2.0
"""From a well plan to a scene: tables in field and SI units, shipped wells, mistakes that name row and remedy."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drill_twin.core.errors import SceneError
from drill_twin.core.units import parse
from drill_twin.core.units.dimension import LENGTH
from drill_twin.dynamics.discretisation.notes import notes_on
from drill_twin.scene import Scene, config_dir, load_scene, well_scenes
from drill_twin.scene.lines import yaml_text
from drill_twin.scene.well_plan.catalogue import casing_size
from drill_twin.scene.well_plan.plan import WellPlan
from drill_twin.scene.well_plan.tally import TallyPiece, marks

INCH, FOOT = 0.0254, 0.3048
SURVEY = "md [m],inc [deg],azi [deg]\n0,0,0\n500,0,0\n900,40,30\n1500,40,30\n"
TALLY = """kind,length [m],od [in],id [in],weight [lb/ft],grade,gauge [in],name
collar,0.5,8,2 13/16,,,,bit sub
stabiliser,2,8,2 13/16,,,12 1/8,near-bit
collar,97.5,8,2 13/16,,,,collars
hwdp,100,5,,,,,
drill pipe,rest,5,,19.5,S-135,,
"""
WELLS = {
    "vertical_3000": {"hole": "12 1/4 in", "casing": ("12.415 in to 1500 m",), "weight_on_bit": "150 kN"},
    "s_shaped": {"hole": "12 1/4 in", "casing": ("12.415 in to 1500 m",), "weight_on_bit": "100 kN"},
    "extended_reach": {"hole": "8 1/2 in", "casing": ("8.681 in to 2500 m",), "weight_on_bit": "80 kN"},
    "drillbotics": {
        "hole": "1 1/2 in", "mud": "1 sg", "viscosity": "1 cP", "weight_on_bit": "150 N", "rotation": "400 rpm",
    },
}  # fmt: skip


def test_a_tally_without_collars_has_no_mark_of_this_name():
    """Of a bit, a motor and pipe the middle of the bit was called collars."""
    row: Any = None
    rows = (("bit", 0.27), ("motor", 8.0), ("pipe", 0.27), ("pipe", 900.0))
    found = marks([TallyPiece(row, {}, kind, length, 0.2) for kind, length in rows])
    assert [mark["name"] for mark in found] == ["near_bit", "motor", "middle"]


def test_a_near_bit_stabiliser_has_no_second_mark_beside_near_bit():
    """Marks at 1 m and 1.07 m told the same motion twice; the next stabiliser keeps its name."""
    row: Any = None
    rows = (("bit", 0.3), ("stabiliser", 1.5), ("collar", 3.0), ("stabiliser", 1.5), ("collar", 82.0), ("pipe", 900.0))
    found = marks([TallyPiece(row, {}, kind, length, 0.2) for kind, length in rows])
    assert [mark["name"] for mark in found] == ["near_bit", "stabiliser", "collars", "middle"]
    assert [mark["distance_from_bit"] for mark in found][:2] == ["1 m", "5.55 m"]


def made(folder: Path, survey: str = SURVEY, tally: str = TALLY, **plan: object) -> Scene:
    (folder / "survey.csv").write_text(survey)
    (folder / "tally.csv").write_text(tally)
    options = {"hole": "12 1/4 in"} | plan
    return WellPlan("mine", folder / "survey.csv", folder / "tally.csv", **options).scene()[0]


@pytest.mark.parametrize("name", WELLS)
def test_shipped_wells_are_what_their_tables_give(name: str) -> None:
    folder = config_dir() / "wells"
    plan = WellPlan(name, folder / f"{name}_survey.csv", folder / f"{name}_tally.csv", **WELLS[name])
    scene, data = plan.scene()
    assert load_scene(f"wells/{name}") == scene
    assert (folder / f"{name}.yaml").read_text("utf-8").endswith(yaml_text(data))


def test_every_shipped_well_is_compared() -> None:
    assert {f"wells/{name}" for name in WELLS} == set(well_scenes())
    collars = [s.length for s in load_scene("wells/vertical_3000").string.sections if s.name != "drill pipe"]
    assert math.fsum(collars) == pytest.approx(500.0)


def test_the_catalogue_gives_bore_weight_grade_and_joints(tmp_path: Path) -> None:
    """5 in. 19.5 lb/ft S-135: API RP 7G has a bore of 4.276 in. and 712,070 lbf of tension at yield."""
    pipe = made(tmp_path).string.sections[-1]
    assert pipe.length == pytest.approx(1300.0)
    assert pipe.inner_diameter == pytest.approx(4.276 * INCH)
    assert pipe.yield_strength * pipe.area / 4.4482216 == pytest.approx(712_070.0, rel=1e-4)
    assert pipe.adjusted_mass > pipe.density * pipe.area
    assert pipe.contact_diameter == pytest.approx(6.625 * INCH)
    stabiliser = made(tmp_path).string.sections[1]
    assert (stabiliser.youngs_modulus, stabiliser.density) == (206.8e9, 7850.0)
    assert stabiliser.contact_diameter == pytest.approx(12.125 * INCH)


def test_a_motor_has_the_bore_that_follows_from_its_weight(tmp_path: Path) -> None:
    """8 in. with a bore of 2 13/16 in. weighs 150 lb/ft."""
    tally = TALLY.replace("collar,97.5,8,2 13/16,", "motor,9,8,,149.8")
    motor = made(tmp_path, tally=tally).string.sections[2]
    assert motor.inner_diameter == pytest.approx(2.8125 * INCH, rel=0.01)
    assert motor.adjusted_mass is None


def test_a_weight_beside_a_bore_counts_or_is_contradicted(tmp_path: Path) -> None:
    """A row weighs what the table says, with tool joints and with grooves; three numbers give the fourth."""
    body = 0.25 * math.pi * ((5.5 * INCH) ** 2 - (4.778 * INCH) ** 2)
    tally = "kind,length [m],od [in],id [in],weight [kg/m],material,name\ncollar,120,7,3,155,,spiral collars\n"
    jointed = made(tmp_path, tally=f"{tally}tube,rest,5.5,4.778,38.2,,pipe\n").string.sections
    assert [section.mass_per_length for section in jointed] == pytest.approx([155.0, 38.2])
    mass = f"{2700.0 * body:.9g}"
    for row in (f"5.5,,{mass},aluminium", "5.5,4.778,,Al", f",4.778,{mass},aluminium", f"5.5,4.778,{mass},"):
        (light,) = made(tmp_path, tally=f"{tally}tube,rest,{row},pipe\n").string.sections[1:]
        found = (light.outer_diameter, light.inner_diameter, light.mass_per_length, light.youngs_modulus)
        assert found == pytest.approx((5.5 * INCH, 4.778 * INCH, 2700.0 * body, 69e9))


CONTRADICTIONS = {
    "light pipe": ("tube,rest,5,4.276,12,", r"weight: expected 17.95.* at most 26.92.* lb/ft, found 12 lb/ft"),
    "more than a bar": ("motor,rest,6.75,3,150,", r"weight: expected 97.* at most 121.* lb/ft, found 150 lb/ft$"),
    "a collar in kg/m": ("collar,rest,6.5,2.8125,136.6,", r"weight: expected 91.\d+ lb/ft .*, found 136.6 lb/ft"),
    "a collar 6 % light": ("collar,rest,6.5,2.8125,86.2,", r"weight: expected 91.\d+ lb/ft .*, found 86.2 lb/ft"),
    "a collar as light as aluminium": ("collar,rest,6.5,2.8125,31.6,", r"91.* by od, id and `material`, .*found 31.6"),
    "steel called aluminium": ("tube,rest,5,4.276,19.5,Al", r"expected 6.17.* at most 9.2.*, found 19.5 lb/ft"),
    "aluminium called steel": ("tube,rest,5,4.276,6.2,steel", r"weight: expected 17.95.*, found 6.2 lb/ft"),
    "bore of another pipe": ("drill pipe,rest,5,3,19.5,", r"5 in 19.5 lb/ft \(bore 4.276.*found od 5 in, id 3 in"),
    "weight of another pipe": ("drill pipe,rest,5,4.276,25.6,", r"with joints 21.92.*, weight 25.6 lb/ft"),
    "weight in kg/m": ("drill pipe,rest,5,,29.02,", r"5 in 25.6 lb/ft .*found od 5 in, weight 29.02 lb/ft"),
    "heavy-weight": ("hwdp,rest,5,3,60,", r"with joints 49.3.*found .*, weight 60 lb/ft; .*as `tube`"),
}  # fmt: skip
HEADING = "kind,length [ft],od [in],id [in],weight [lb/ft],material,grade,gauge [in]\n"


@pytest.mark.parametrize("row", CONTRADICTIONS)
def test_a_contradiction_of_more_than_5_percent_is_a_sentence_with_both_numbers(tmp_path: Path, row: str) -> None:
    text, message = CONTRADICTIONS[row]
    with pytest.raises(SceneError, match=rf"tally.csv, line 2.*{message}"):
        made(tmp_path, tally=f"{HEADING}{text}\n")


@pytest.mark.parametrize("row", ["jar,30,6.5,2.75,80", "motor,30,6.75,4.5,36"])
def test_the_od_of_a_tool_is_its_largest(tmp_path: Path, row: str) -> None:
    tool, _ = made(tmp_path, tally=f"{HEADING}{row}\ncollar,rest,6.5,2.8125,\n").string.sections
    assert tool.mass_per_length == pytest.approx(float(row.rpartition(",")[2]) * 0.45359237 / FOOT, rel=1e-6)


def test_a_force_per_length_is_a_weight(tmp_path: Path) -> None:
    for unit, weight in (("daN/m", 134.0), ("N/m", 1340.0), ("KG/M", 134.0 / 0.980665)):
        heading = HEADING.replace("lb/ft", unit)
        (collar,) = made(tmp_path, tally=f"{heading}collar,rest,6.5,2.8125,{weight!r}\n").string.sections
        assert collar.mass_per_length == pytest.approx(1340.0 / 9.80665, rel=1e-2), unit
    with pytest.raises(SceneError, match="daX/m"):
        made(tmp_path, tally=f"{HEADING.replace('lb/ft', 'daX/m')}collar,rest,6.5,2.8125,134\n")


def test_weights_that_differ_by_less_than_5_percent_are_no_contradiction(tmp_path: Path) -> None:
    for row in (
        "tube,rest,5,4.276,17.2",
        "collar,rest,6.5,2.8125,95",
        "hwdp,rest,5,3,51",
        "hwdp,rest,5,,50.5",
        "dp,rest,5,4.276,22.6",
    ):
        (section,) = made(tmp_path, tally=f"{HEADING}{row}\n").string.sections
        assert section.mass_per_length == pytest.approx(float(row.rpartition(",")[2]) * 0.45359237 / FOOT, rel=1e-6)


@pytest.mark.parametrize(("row", "weight", "bore"), [
    ("5.5,,24.7", 27.74, 4.67), ("5.5,,24.8", 24.8, 4.778), ("5.5,,21.9", 24.8, 4.778), ("5.5,4.778,24.7", 24.7, 4.778),
    ("5.5,4.67,24.7", 27.74, 4.67), ("3.5,2.764,13.3", 14.06, 2.764), ("3.5,2.602,", 16.54, 2.602),
])  # fmt: skip
def test_weight_of_drill_pipe_is_nominal_or_with_joints(tmp_path: Path, row: str, weight: float, bore: float) -> None:
    """Whichever is nearer; a bore tells the pipe."""
    (section,) = made(tmp_path, tally=f"{HEADING}drill pipe,rest,{row}\n").string.sections
    assert section.mass_per_length == pytest.approx(weight * 0.45359237 / FOOT, rel=1e-5)
    assert section.inner_diameter == pytest.approx(bore * INCH)


SIX = {
    "od and bore": """kind,length [ft],od [in],id [in],weight [lb/ft],grade
bit,1,8.5,2.25,,\nrss,20,6.75,2.5,,\nmotor,30,6.75,4.0,,\ncollar,300,6.5,2 13/16,,
jar,30,6.5,2.75,,\ncollar,60,6.5,2 13/16,,
hwdp,500,5,3,,\ndrill pipe,rest,5,4.276,,S-135
""",
    "od and weight": """kind,length [ft],od [in],weight [lb/ft],grade
bit,1,8.5,179.42,\nrss,20,6.75,105.078,\nmotor,30,6.75,78.961,\ncollar,300,6.5,91.79,\njar,30,6.5,92.71,\ncollar,60,6.5,91.79,
hwdp,500,5,49.3,\ndrill pipe,rest,5,19.5,S-135
""",
    "all in SI, without grade": """kind,length [m],od [mm],id [mm],weight [kg/m]
bit,0.3048,215.9,57.15,267.0\nrss,6.096,171.45,63.5,156.37\nmotor,9.144,171.45,101.6,117.51\ncollar,91.44,165.1,71.4375,136.6
jar,9.144,165.1,69.85,137.97\ncollar,18.288,165.1,71.4375,136.6\nhwdp,152.4,127,76.2,73.37\ndp,rest,127,108.61,32.62
""",
    "decimal commas": """Komponente;kind;length [m];o.d. [mm];bore [mm];wt [kg/m];grade
1;Bit;0,3048;215,9;57,15;;-\n2;RSS;6,096;171,45;63,5;-;n/a\n3;PDM;9,144;171,45;101,6;;\n4;DC;91,44;165,1;71,4375;;
5;Jars;9,144;165,1;69,85;;\n6;DC;18,288;165,1;71,4375;;\n7;HWDP;152,4;127;;;\n8;DP;rest;127;;29,02;S
""",
    "names of the trade, each joint, from the top": """Component,Length (ft),OD (in.),ID (in.),Weight (ppf),Material
Drill Pipe,rest,5.000,,21.92,\n5 in spiral HWDP,250,5,,49.3,\nHeavy-Weight Drill Pipe,250,5,3,,steel
Drill collars,60,6 1/2,,91.79,\nHydraulic jar,30,6.5,2.75,92.71,\n"""
    + "Non-mag drill collar,30,6.5,2 13/16,91.79,non-mag\n" * 10
    + """Mud motor,30,6.75,4,,\nRotary steerable system,20,6.75,2.5,105.08,\nPDC bit,1,8.5,2.25,179.42,
""",
    "units in the cells, weights with joints, as tubes": """kind,length,od,id,weight,serial number
bit,1 ft,8 1/2",2 1/4",,A1\nsub,20 ft,6 3/4 in,2.5 in,,\ntube,9.144 m,171.45 mm,,117.51 kg/m,
collar,300 ft,,2 13/16 in,91.79 ppf,
tube,30 ft,6.5 in,2.75 in,92.71 lbs/ft,\ncollar,60 ft,6.5 in,2 13/16 in,91.79 lb/ft,\ntube,500 ft,5 in,3 in,49.3 lb/ft,
tube,rest,5 in,4.276 in,21.92 lbm/ft,
""",
}  # fmt: skip


def test_one_string_described_in_six_ways_weighs_the_same(tmp_path: Path) -> None:
    """Within 0.1 %: of 3559 ft of drill pipe of 21.92 lb/ft and 941 ft below it, each from maker's numbers."""
    survey = f"md [m],inc [deg],azi [deg]\n0,0,0\n{4500 * FOOT!r},0,0\n"
    below = 179.42 + 20 * 105.08 + 30 * 78.96 + 360 * 91.79 + 30 * 92.71 + 500 * 49.3
    for way, tally in SIX.items():
        scene = made(tmp_path, survey, tally, hole="8 1/2 in")
        weight = sum(section.mass_per_length * section.length for section in scene.string.sections) / 0.45359237
        assert weight == pytest.approx(3559 * 21.92 + below, rel=1e-3), way
        assert scene.string.sections[0].length == pytest.approx(FOOT), way


def test_a_bit_as_wide_as_the_hole_is_held_in_it(tmp_path: Path) -> None:
    """Solid where it has no bore; a wider one is refused, as is a collar as wide as the hole."""
    scene = made(tmp_path, tally=f"{HEADING}bit,1,12.25,,,,,\nstabiliser,5,8,3,160,,,12\ncollar,rest,8,3,,,,\n")
    bit, stabiliser, _ = scene.string.sections
    assert bit.inner_diameter == 0.0
    assert 0.98 * 12.25 * INCH < bit.contact_diameter < 12.25 * INCH
    assert stabiliser.mass_per_length == pytest.approx(160.0 * 0.45359237 / FOOT)
    assert not [note for note in notes_on(scene) if "wall, bit," in note]
    for row in ("bit,1,12.3,,,,,", "collar,1,12.25,3,,,,"):
        with pytest.raises(SceneError, match=r"tally.csv, line 2 .*narrowest hole that it passes \(12.25 in"):
            made(tmp_path, tally=f"{HEADING}{row}\ncollar,rest,8,3,,,,\n")


def test_a_bit_is_of_the_type_that_plan_or_tally_names(tmp_path: Path) -> None:
    """Diameter, type, or both, in any spelling; what the plan lacks is the tally's, else the hole's."""
    rows = "{}bit,1,12,3,,,,\ncollar,rest,8,3,,,,\n"
    for named, bit, kind in (
        ("", "", None), ("", "pdc", "pdc"), ("PDC ", "", "pdc"), ("PDC ", "12 in", "pdc"), ("PDC ", "12 in pdc", "pdc"),
        ("roller-cone ", "", "roller_cone"), ("12 in PDC ", "", "pdc"), ("matrix pdc ", "304.8 mm", "pdc"),
        ("bi-centre ", "", "bicentre"), ("PDC bicenter ", "", "bicentre"), ("tricone ", "", "roller_cone"),
        ("", '12" Tri-cone bit', "roller_cone"), ("", "12in roller cone", "roller_cone"), ("", "bicenter", "bicentre"),
    ):  # fmt: skip
        law = made(tmp_path, tally=HEADING + rows.format(named), bit=bit).effects.bit_torque_stribeck
        assert law.bit == kind, (named, bit)
        assert law.radius == pytest.approx(12.0 * INCH / 3.0, rel=1e-5)
        assert law.sliding == {None: 0.4, "pdc": 0.7, "roller_cone": 0.2, "bicentre": 0.8}[kind]
    law = made(tmp_path, bit="12 1/8 in hybrid").effects.bit_torque_stribeck
    assert (law.bit, law.radius) == ("hybrid", pytest.approx(12.125 * INCH / 3.0, rel=1e-5))
    assert made(tmp_path).effects.bit_torque_stribeck.radius == pytest.approx(12.25 * INCH / 3.0, rel=1e-5)


@pytest.mark.parametrize("hole", ["12 1/4 in", "8 1/2 in"])
def test_the_bit_of_a_tally_has_its_own_diameter_and_no_other(tmp_path: Path, hole: str) -> None:
    """A pilot bit below a reamer, and a bit less than its hole; the name of the row may have its type."""
    rows = f"name,{HEADING}tricone,bit,1,6,2,,,,\n,collar,rest,6,2,,,,\n"
    law = made(tmp_path, tally=rows, hole=hole).effects.bit_torque_stribeck
    assert (law.bit, law.radius) == ("roller_cone", pytest.approx(2.0 * INCH, rel=1e-5))
    for bit, found in ((f"{hole} tricone", "6 in roller_cone"), ("6 in pdc", "6 in roller_cone"), (hole, "6 in")):
        with pytest.raises(SceneError, match=rf"line 2: expected the bit of --bit \({bit}\), found {found}.*correct"):
            made(tmp_path, tally=rows, hole=hole, bit=bit)
    with pytest.raises(SceneError, match=r"line 3: expected one bit, found another; take it out"):
        made(tmp_path, tally=rows.replace(",collar", ",bit,1,6,2,,,,\n,collar"), hole=hole)


@pytest.mark.parametrize("bit", ["8 1/2 in pcd", "8.5 in drag", "impregnated", "IADC 517", "pdc 8 1/2 in", "8 1/2 kg"])
def test_a_bit_that_is_not_understood_is_told_the_types(tmp_path: Path, bit: str) -> None:
    with pytest.raises(
        SceneError, match=f'^--bit: expected .*pdc, roller_cone, hybrid, bicentre, .*found "{bit}"; leave'
    ):
        made(tmp_path, bit=bit)


def test_no_weight_and_no_rotation_need_no_unit_in_field_units(tmp_path: Path) -> None:
    scene = made(tmp_path, units="field", weight_on_bit="0", rotation="0")
    assert (scene.rig.weight_on_bit.value, scene.rig.rotation.value) == (0.0, 0.0)
    with pytest.raises(SceneError, match="--wob: expected a force"):
        made(tmp_path, units="field", weight_on_bit="1")


def test_what_is_modelled_of_a_motor_and_a_reamer_is_told(tmp_path: Path) -> None:
    rows = "bit,1,12.25,,,,,\nmotor,30,8,5,,,,\nunderreamer,10,8,3,,,,13\ncollar,rest,8,3,,,,\n"
    scene = made(tmp_path, tally=HEADING + rows, hole="13.5 in", bit="12.25 in")
    assert scene.string.sections[2].contact_diameter == pytest.approx(13.0 * INCH)
    assert [mark.name for mark in scene.string.marks][1:3] == ["motor", "reamer"]
    assert "motor: a tube that turns with the string; its bend" in scene.provenance
    assert "reamer: a tube with blades" in scene.provenance
    assert "rotary steerable" not in scene.provenance


def test_tools_have_marks_and_drill_pipe_without_grade_is_of_the_weakest(tmp_path: Path) -> None:
    rows = "rss,20,6.75,2.5,,,,8\nLWD,30,6.75,3,,,,\njar,30,6.5,2.75,,,,\nhwdp,200,5,,,,4145H,\ndp,rest,5,,19.5,,,\n"
    scene = made(tmp_path, tally=HEADING + rows)
    string = scene.string
    assert "rotor" not in scene.provenance
    assert [mark.name for mark in string.marks] == ["near_bit", "rss", "lwd", "jar", "middle"]
    assert string.sections[0].contact_diameter == pytest.approx(8.0 * INCH)
    assert string.sections[-1].yield_strength == pytest.approx(75.0 * 6.894757e6, rel=1e-5)


def test_field_and_si_tables_give_one_scene(tmp_path: Path) -> None:
    survey = "MD,INC,AZI\n" + "".join(
        f"{depth / FOOT!r},{angle},{way}\n"
        for depth, angle, way in ((0, 0, 0), (500, 0, 0), (900, 40, 30), (1500, 40, 30))
    )
    tally = (
        f"type;length;od;id;weight;grade;gauge;name\ncollar;{0.5 / FOOT!r};8;2 13/16;;;;bit sub\n"
        f"stabilizer;{2 / FOOT!r};8;2.8125;;;12 1/8;near-bit\ncollar;{97.5 / FOOT!r};8;2 13/16;;;;collars\n"
        f"hwdp;{100 / FOOT!r};5;;;;;\ndrill pipe;rest;5;;19.5;S135;;\n"
    )
    field, own = made(tmp_path, survey, tally, units="field"), made(tmp_path)
    for one, other in zip(field.hole.survey, own.hole.survey, strict=True):
        assert one.depth == pytest.approx(other.depth, abs=1e-6)
        assert (one.inclination, one.azimuth) == (other.inclination, other.azimuth)
    for one, other in zip(field.string.sections, own.string.sections, strict=True):
        assert one.length == pytest.approx(other.length, abs=1e-6)
        assert (one.outer_diameter, one.inner_diameter, one.adjusted_mass) == pytest.approx(
            (other.outer_diameter, other.inner_diameter, other.adjusted_mass)
        )


def test_pipe_need_only_pass_the_diameters_above_its_lower_end(tmp_path: Path) -> None:
    """6 5/8 in. pipe with joints of 8 in. in casing, above a hole of 7 7/8 in."""
    tally = (
        "kind,length [m],od [in],id [in],weight [lb/ft],grade\ncollar,100,6 1/4,2 1/4,,\n"
        "drill pipe,900,4 1/2,,16.6,G-105\ndrill pipe,rest,6 5/8,,25.2,S-135\n"
    )
    assert made(tmp_path, tally=tally, hole="7 7/8 in", casing=("8.681 in to 600 m",)).length == 1500.0
    with pytest.raises(SceneError, match=r"tally.csv, line 4 .*narrowest hole that it passes"):
        made(tmp_path, tally=tally, hole="7 7/8 in", casing=("8.681 in to 400 m",))


MISTAKES = {
    "back in feet": (
        {"survey": "md [ft],inclination [deg],azimuth [deg]\n0,0,0\n5000,0,0\n4000,20,0\n"},
        r"row above \(5000 ft\), found 4000 ft: the survey does not go down",
    ),
    "depth in feet": ({"depth": "9000 ft", "units": "field"}, r"survey \(4921.26 ft\), found 9000 ft"),
    "back": ({"survey": SURVEY.replace("900,40", "400,40")}, r"survey.csv, line 4: .*does not go down; sort the rows"),
    "again": ({"survey": SURVEY.replace("900,40", "500,40")}, r"survey.csv, line 4: .*the survey does not go down"),
    "jump": ({"survey": SURVEY.replace("900,40", "510,40")}, r"survey.csv, line 4: .*jump of 40 deg in 10 m; correct"),
    "text": ({"survey": SURVEY.replace("900,40", "900,forty")}, r"survey.csv, line 4, inclination: .*forty"),
    "empty": ({"survey": SURVEY.replace("900,40", "900,")}, r"survey.csv, line 4: .*inclination, found none; give it"),
    "column": ({"survey": "md,inc\n0,0\n"}, r"survey.csv, line 1: .*found no azimuth; known headings"),
    "unit of the column": ({"survey": SURVEY.replace("md [m]", "md [kg]")}, r"survey.csv, line 2, md: .*kg"),
    "mixed units": ({"tally": TALLY.replace("97.5,8", "320 ft,8")}, r"tally.csv, line 4, length: .*in m as in the"),
    "too long": ({"tally": TALLY.replace("rest", "1500")}, r"tally.csv, line 6: .*\(1500 m\), found 1700 m; shorten"),
    "two rests": ({"tally": TALLY.replace("hwdp,100", "hwdp,rest")}, r"tally.csv, line 6: .*at most one .*, found 2"),
    "wide pipe": ({"hole": "7 in"}, r'tally.csv, line 2 \("bit sub"\): .*take a smaller od, or correct hole'),
    "wide blades": ({"hole": "12 in"}, r'tally.csv, line 3 \("near-bit"\): .*take a smaller gauge, or correct hole'),
    "no gauge": ({"tally": TALLY.replace("12 1/8", "")}, r"tally.csv, line 3, gauge: .*found nothing"),
    "small gauge": ({"tally": TALLY.replace("12 1/8", "7")}, r"line 3: .* at least the od, found .*, gauge 7 in"),
    "grade": ({"tally": TALLY.replace("S-135", "19.5")}, r'tally.csv, line 6, grade: .*S135.* found "19.5"; weights'),
    "size": ({"tally": TALLY.replace("19.5", "18.0")}, r"tally.csv, line 6: .*5 in 19.5 lb/ft.*weight 18.0 lb/ft"),
    "kind": ({"tally": TALLY.replace("hwdp", "wire")}, r'tally.csv, line 5, kind: .*found "wire"'),
    "bore": ({"tally": TALLY.replace("97.5,8,2 13/16", "97.5,8,9")}, r"line 4: .*less than the od, found .*, id 9 in"),
    "no bore": ({"tally": TALLY.replace("97.5,8,2 13/16", "97.5,8,")}, r"line 4: expected two .*, found od 8 in$"),
    "a bar": ({"tally": TALLY.replace("97.5,8,2 13/16,", "97.5,8,,200")}, r"line 4, weight: expected 171.*, found 200"),
    "depth": ({"depth": "1600 m"}, r"--depth: .*within the survey \(1500 m\), found 1600 m"),
    "bit": ({"bit": "13 in"}, r"--bit: expected at most the hole"),
    "casing": ({"casing": ("13 in to 500 m", "13 in to 400 m")}, r"--casing .*expected a shoe below 500 m"),
    "shoe": ({"casing": ("13 in",)}, r'--casing: expected ID and shoe as .*found "13 in"'),
    "hole": ({"hole": "-12 in"}, r'--hole: expected a length above 0, found "-12 in"'),
    "above the rotary table": ({"depth": "-5 m"}, r"--depth: expected a length above 0"),
    "thousands": ({"survey": SURVEY.replace("900,40", "1,900,40")}, r"survey.csv, line 4: .*at most 3 cells"),
    "heavy in mm": ({"tally": TALLY.replace("hwdp,100,5", "hwdp,100,8")}, r"line 5: .*5 in 49.3 lb/ft .*found od 8 in"),
    "no unit": ({"survey": SURVEY.replace("md [m]", "md")}, r"line 2, md: expected its unit, .* as md \[ft\], or give"),
    "no unit of a size": ({"tally": TALLY.replace("od [in]", "od")}, r'line 2, od: expected its unit, .* "8"'),
    "size of casing": ({"casing": ("9 5/8 in to 900 m",)}, r'the inner diameter .*found 9 5/8 in, .*"ID 9 5/8 in to'),
    "the same in mm": ({"casing": ("244.5 mm to 900 m",)}, r"--casing .*found 9 5/8 in, an outer diameter of API 5CT"),
    "pulled": ({"weight_on_bit": "-12 klb"}, r'--wob: expected a force from 0, found "-12 klb"'),
    "left-handed": ({"rotation": "-120 rpm"}, r'--rpm: expected a speed of rotation from 0, found "-120 rpm"'),
    "thin mud": ({"viscosity": "0 cP"}, r'^--viscosity: expected a viscosity above 0, found "0 cP"'),
    "one station": ({"survey": "md [m],inc,azi\n0,0,0\n"}, r"survey.csv: expected two or more stations .*found 1"),
    "unit": ({"hole": "12 kg"}, r"--hole: .*12 kg"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line_that_names_row_and_remedy(tmp_path: Path, mistake: str) -> None:
    changes, message = MISTAKES[mistake]
    with pytest.raises(SceneError, match=message) as caught:
        made(tmp_path, **changes)
    assert "\n" not in str(caught.value)


def test_a_bore_that_is_also_a_size_of_casing_is_taken_where_it_is_called_one(tmp_path: Path) -> None:
    """And no bore of API casing is taken for an outer diameter."""
    hole = made(tmp_path, casing=("ID 13 3/8 in to 900 m",)).hole
    assert hole.intervals[0].radius == pytest.approx(0.5 * 13.375 * INCH)
    for bore in ("12.415", "8.681", "19.124", "6.184", "4.494", "5.012", "7.025", "17.755", "9.760"):
        assert not casing_size(parse(f"{bore} in", LENGTH))


def test_friction_of_the_casing(tmp_path: Path) -> None:
    options = {"casing": ("12.7 in to 400 m", "12.415 in to 900 m"), "friction": 0.3, "cased_friction": 0.15}
    friction = made(tmp_path, **options).effects.wall_friction
    assert friction.scale_at(np.array([0.0, 899.0, 901.0])) * friction.coefficient == pytest.approx([0.15, 0.15, 0.3])
    with pytest.raises(SceneError, match="--cased-friction: expected a casing with it, found none"):
        made(tmp_path, cased_friction=0.15)
    with pytest.raises(SceneError, match=r"^--friction: expected a coefficient above 0 beside --cased-friction"):
        made(tmp_path, **(options | {"friction": 0.0}))


def test_semicolons_and_decimal_commas_are_read(tmp_path: Path) -> None:
    def written(text: str) -> str:
        return text.replace(",", ";").replace(".", ",")

    assert made(tmp_path, survey=written(SURVEY), tally=written(TALLY)) == made(tmp_path)
