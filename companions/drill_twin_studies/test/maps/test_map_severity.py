# SPDX-License-Identifier: Apache-2.0
"""Severity, kind and what may still come of a run: by hand, and on a string of collars that rolls after 40 s."""

import math
from dataclasses import replace

import numpy as np
import pytest
from coarse_map import COARSE

import drill_twin as dt
from drill_twin.core.severity import Grade
from drill_twin.runs.ensemble import Threads, expand
from drill_twin.runs.ensemble.outputs import Request
from drill_twin.scene import parse_scene
from drill_twin.whirl import MotionState, Summary
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.findings import MotionPeriod
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span
from drill_twin_studies.maps.drawing import GRADES, page_data, shown
from drill_twin_studies.maps.regimes import TorsionalSpeeds, regime_of
from drill_twin_studies.maps.rolling import RollingFriction
from drill_twin_studies.maps.runs import Key, Runner, RunRecord

STEADY = TorsionalSpeeds(0.1, 12.0, 12.0)
PLANE = Plane(Span(0.0, 160.0), Span(0.0, 16.0), 16)
COLLARS = """
name: collars
string:
  sections:
  - {name: collars, length: 180 m, outer_diameter: 0.2032 m, inner_diameter: 0.0714375 m}
  - {name: drill pipe, length: 400 m, outer_diameter: 0.127 m, inner_diameter: 0.1086 m}
  marks:
  - {name: bit, distance_from_bit: 1 m}
  - {name: collars, distance_from_bit: 90 m}
  - {name: middle, distance_from_bit: 290 m}
  bit_end: pinned
hole: {radius: 0.155575 m}
rig:
  weight_on_bit: {shape: step, value: 40 klbf, start: 10 s, duration: 10 s}
  rotation: {shape: step, value: 200 rpm, duration: 10 s}
  duration: 60 s
effects:
  gravity: {}
  stretch: {}
  torsion: {}
  eccentricity: {offset: 1 mm}
  mud: {density: 1200 kg/m^3, viscosity: 20 cP}
  internal_damping: {bending_time: 1 ms, stretch_time: 1 ms, torsion_time: 1 ms}
  added_mass: {}
  quadratic_drag: {}
  rotation_drag: {}
  wall: {stiffness: 1e10 N/m^2.5}
  wall_friction: {coefficient: 0.3}
numerics: {frame_rate: 50 Hz}
"""


AS_A_WELL = {
    "effects.mud.viscosity": "1e-6 cP", "effects.viscous_drag": {}, "effects.eccentricity": "off",
    "effects.bit_torque_stribeck": {"radius": "1 mm", "sliding": 0.0, "sticking": 0.0, "decay": "1 s/rad"},
}  # fmt: skip
"""Effects at next to nothing, so that the equations are those of the statics of vertical_3000."""


def of(state, ratio=-0.5, bit=BitMotion.STEADY, **more):
    """Findings with one motion."""
    return Summary(motion=(MotionPeriod(0.0, state, ""),), mean_ratio=ratio, bit=bit, **more)


def kind(summary, torsion=STEADY):
    """Regime of findings."""
    return regime_of(summary, [0.1], torsion, vertical=True, grows=False)


@pytest.mark.parametrize(
    ("state", "regime"),
    [
        (MotionState.CREEPING, Regime.CREEPING),
        (MotionState.ROLLING, Regime.ROLLING),
        (MotionState.IMPACTS, Regime.IMPACTS),
        (MotionState.BACKWARD_WHIRL, Regime.BACKWARD),
        (MotionState.PLANE_SWING, Regime.SWING),
        (MotionState.SPIRAL, Regime.BACKWARD),
    ],
)
def test_each_motion_has_its_kind(state, regime):
    assert kind(of(state)) is regime


def test_of_a_shape_of_the_string_the_widest_mark_names_the_motion():
    rolling = {"mark_2": (MotionPeriod(0.0, MotionState.ROLLING, ""),)}
    shape = of(MotionState.SECOND_BENDING, -1.88, mark_motion=rolling, frequency_mark="mark_2")
    assert kind(shape) is Regime.ROLLING


def test_a_free_swing_that_decays_is_no_vibration():
    torsion = TorsionalSpeeds(0.7, 12.0, 12.0)
    assert kind(of(MotionState.FIXED_AXIS, 0.0), torsion) is Regime.VIBRATION
    assert kind(of(MotionState.FIXED_AXIS, 0.0, BitMotion.DECAYING), torsion) is Regime.SMOOTH


def test_codes_of_messages_stay():
    old = (Regime.SMOOTH, Regime.VIBRATION, Regime.STICK_SLIP, Regime.BUCKLED, Regime.SWING, Regime.UNSETTLED,
           Regime.FORWARD, Regime.BACKWARD, Regime.IRREGULAR, Regime.FAILED)  # fmt: skip
    assert [regime.code for regime in old] == list(range(10))


def map_of(record_at):
    """Map with a run at each node, growth of the straight string beyond 80 N."""
    records = {Key(i, j): record_at(i, j) for i in range(17) for j in range(17)}
    growth = np.add.outer(np.linspace(-1.0, 1.0, 33), np.zeros(33)).tolist()
    return OperatingMap("string", "", "", PLANE, 30.0, (), records, growth=growth, asked=300.0)


CREEP = RunRecord(Regime.CREEPING, lateral_rms_g=0.03, severity=Grade.NONE)
SMOOTH = RunRecord(Regime.SMOOTH, severity=Grade.NONE)


@pytest.mark.parametrize(
    ("beyond", "calm"),
    [
        (CREEP, True),
        (RunRecord(Regime.SWING, severity=Grade.LOW), True),
        (replace(CREEP, severity=Grade.MEDIUM), False),
        (replace(CREEP, unsettled="it may come to roll"), False),
        (replace(CREEP, severity=None), False),
        (RunRecord(Regime.ROLLING, severity=Grade.LOW), False),
        (replace(SMOOTH, severity=Grade.MEDIUM), False),
        (RunRecord(Regime.UNSETTLED, severity=Grade.NONE), False),
    ],
)
def test_windows_hold_what_is_calm_by_its_severity(beyond, calm):
    """Below 50 N smooth; beyond it the string creeps or swings, and beyond 80 N the straight string grows."""
    found = map_of(lambda i, _: beyond if i > 5 else SMOOTH)
    assert beyond.calm == calm
    assert found.window_cells[6:7].any() == calm
    assert found.window_cells[12].any() == (beyond is CREEP)  # the growth is of the string on its axis
    assert found.calm[12, 8] == (beyond is CREEP)


def test_an_existing_whirl_that_creeps_on_is_calm_only_if_its_creeping_is():
    for run, keeps in ((CREEP, False), (replace(CREEP, unsettled="it may come to roll"), True), (SMOOTH, False)):
        found = map_of(lambda *_: SMOOTH)
        falling = {Key(i, j, 0, (16, 16)): run for i in range(17) for j in range(17)}
        assert replace(found, records={**found.records, **falling}).keeps_whirling.any() == keeps


def test_the_window_says_by_which_bounds_it_is_calm():
    found = map_of(lambda *_: CREEP)
    assert "289 runs of 30 s in them and at their corners, all calm (289 creeping along the wall)" in found.basis[0]
    assert "below medium, which begins at lateral acceleration, rms 2 g; lateral acc" in found.basis[1]
    assert "stick-slip index 0.5 (bounds: of this program, not of a vendor)" in found.basis[1]
    own = dt.load_scene("pa6_bench", {"severity": {"source": "manual X", "lateral_rms": [1.0, 2.9419950, 10.0, 20.0]}})
    said = replace(found, scene=own.to_yaml()).basis[1]
    assert "(bounds: manual X, for lateral acceleration rms; for the others of this program" in said
    assert "lateral acceleration, rms 0.3 g" in said


def test_a_run_has_the_acceleration_of_its_marks_and_the_grade_by_the_bounds_of_its_scene():
    """Second differences of the positions of each frame, second half of the run, made here."""
    scene = dt.load_scene("pa6_bench", COARSE)
    plane = Plane(Span(1.0, 40.0), Span(math.tau, 2.0 * math.tau), 8)
    (record,) = (record for _, record in Runner(scene, plane, 20.0, 20.0, (), Threads(1)).run([Key(8, 8)]))
    period = scene.numerics.frame_period
    frames = round(20.0 / period)
    asked = Request(("marks",), period, frames, 1)
    ((_, run),) = Threads(1).run(expand(scene, {"wob": [40.0], "rpm": [120.0]}, zipped=True), asked)
    line = run.values["centre"].value @ [1.0, 1j]
    shaken = np.abs(line[2:] - 2.0 * line[1:-1] + line[:-2])[frames // 2 - 2 :] / period**2 / 9.80665
    assert record.lateral_rms_g == pytest.approx(np.sqrt((shaken**2).mean(axis=0)).max(), rel=1e-3)
    assert record.lateral_peak_g == pytest.approx(shaken.max(), rel=1e-6)
    assert record.regime is Regime.FORWARD
    assert record.severity is Grade.NONE
    strict = dt.load_scene(
        "pa6_bench", {**COARSE, "severity": {"source": "manual X", "lateral_rms": [0.1, 0.2, 0.5, 1.0]}}
    )
    (again,) = (record for _, record in Runner(strict, plane, 20.0, 20.0, (), Threads(1)).run([Key(8, 8)]))
    assert (again.severity, again.decided_by) == (Grade.SEVERE, "lateral_rms")


def test_a_run_that_failed_has_no_severity_in_picture_and_table():
    found = map_of(lambda i, _: RunRecord(Regime.FAILED, failure="stopped") if i > 12 else SMOOTH)
    assert (found.severities[14:] == -1).all()
    assert (found.severities[:12] == Grade.NONE).all()
    heads, *rows = (line.split(",") for line in found.csv().splitlines())
    assert {row[heads.index("severity")] for row in rows} == {"none", "unknown"}
    scene = dt.load_scene("pa6_bench").to_yaml()
    assert list(page_data(replace(found, scene=scene), "pa6_bench")["grades"]) == list(GRADES)


def test_the_command_of_a_run_is_rounded_in_the_units_of_its_reader():
    scene = dt.load_scene("pa6_bench", {"units": "field"}).to_yaml()
    plane = Plane(Span(22241.1080763025, 200169.9726867225), Span(math.tau, 3.0 * math.tau), 16)
    found = replace(map_of(lambda *_: SMOOTH), scene=scene, plane=plane)
    said = found.command_of(Key(3, 8), "C.yaml")
    assert "rig.weight_on_bit.value=12.5 klbf" in said
    assert "rig.rotation.value=120 rpm" in said


@pytest.mark.slow
def test_rolling_needs_the_friction_that_carries_its_drag():
    """Drag C_d rho r_o (w c)^2 against the centrifugal force of string, mud inside and around it, m w^2 c."""
    scene = parse_scene(COLLARS, name="collars", overrides=AS_A_WELL)
    outer, inner, hole, mud = 0.1016, 0.03571875, 0.155575, 1200.0
    mass = 7850.0 * math.pi * (outer**2 - inner**2) + mud * math.pi * (outer**2 + inner**2)
    for speed in (6.0, 21.0):
        assert RollingFriction(scene).needed(1, speed) == pytest.approx(mud * outer * (hole - outer) / mass, rel=0.02)
    assert RollingFriction(scene).ratio(1) == pytest.approx(outer / (hole - outer))


@pytest.mark.long
def test_collars_that_creep_for_forty_seconds_are_not_settled_and_roll_later():
    """8 in collars at 40 klbf and 200 rpm roll from about 40 s on, with 8 g; before, they creep."""
    scene = parse_scene(COLLARS, name="collars")
    rig = scene.rig
    plane = Plane(Span(0.5 * rig.weight_on_bit.value, rig.weight_on_bit.value), Span(1.0, rig.rotation.value), 8)
    (early,) = (record for _, record in Runner(scene, plane, 40.0, 400.0, (), Threads(1)).run([Key(8, 8)]))
    assert early.regime is Regime.CREEPING
    assert early.severity is Grade.NONE
    assert "it may come to roll" in early.unsettled
    assert not early.calm
    (late,) = (record for _, record in Runner(scene, plane, 120.0, 400.0, (), Threads(1)).run([Key(8, 8)]))
    assert late.regime is Regime.ROLLING
    assert late.severity is Grade.SEVERE
    assert late.lateral_rms_g == pytest.approx(8.1, rel=0.1)
    slippery = parse_scene(COLLARS.replace("coefficient: 0.3", "coefficient: 0.01"), name="collars")
    (slick,) = (record for _, record in Runner(slippery, plane, 40.0, 400.0, (), Threads(1)).run([Key(8, 8)]))
    assert "roll" not in slick.unsettled


def test_a_map_without_a_calm_set_point_has_no_margin_and_says_why():
    scene = dt.load_scene("pa6_bench", overrides={"wob": "5 N", "rpm": "60"})
    nowhere = replace(map_of(lambda *_: RunRecord(Regime.ROLLING)), scene=scene.to_yaml())
    assert nowhere.margin(5.0, 6.0) is None
    (said,) = (line for line in shown(nowhere, scene) if "set-point of the scene" in line)
    assert said.endswith("; no margin, as no set-point of these ranges is calm")
    assert page_data(nowhere, "pa6_bench")["own_margin"] == [None, None, None]
    everywhere = map_of(lambda *_: SMOOTH)
    assert "margin" not in " ".join(shown(replace(everywhere, growth=()), scene))
