# SPDX-License-Identifier: Apache-2.0
"""A scene written out reads back to an equal scene, whatever is in it."""

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from drill_twin.physics.effects.gravity import Gravity
from drill_twin.scene import Scene, parse_scene


def between(low: float, high: float, **options: Any) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False, **options)


TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=80)
LABELS = st.text(st.characters(exclude_categories=["C", "Z"], include_characters=" "), min_size=1, max_size=80)
NAMES = st.from_regex(r"\A[A-Za-z][A-Za-z0-9_]{0,20}\Z")


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    hole = draw(between(0.01, 1.0))
    sections = draw(st.lists(sections_in(hole), min_size=1, max_size=4))
    length = sum(section["length"] for section in sections)
    names = draw(st.lists(NAMES, max_size=4, unique=True))
    widest = max(section["outer_diameter"] for section in sections) / 2.0
    weakest = min(s["youngs_modulus"] * (s["outer_diameter"] ** 2 - s["inner_diameter"] ** 2) for s in sections)
    narrowest = min(section["outer_diameter"] for section in sections) / 2.0
    effects: dict[str, Any] = {"stretch": {}, "torsion": {}}
    if draw(st.booleans()):
        effects["bow"] = {
            "amplitude": draw(between(0.0, hole - widest, exclude_max=True)),
            "shape": draw(st.sampled_from(["half_wave", "uniform"])),
        }
        effects["eccentricity"] = {
            "offset": draw(between(0.0, min(1.0, narrowest), exclude_max=True)),
            "angle": draw(between(-6.0, 6.0)),
        }
    if draw(st.booleans()):
        effects["wall"] = {"stiffness": draw(between(1.0, 1e15)), "restitution": draw(between(0.01, 1.0))}
        effects["wall_friction"] = {"coefficient": draw(between(0.0, 5.0)), "decay": draw(between(0.0, 1e4))}
    return Scene.model_validate(
        {
            "name": draw(LABELS),
            "description": draw(TEXT),
            "provenance": draw(TEXT),
            "string": {
                "sections": sections,
                "marks": [draw(marks(name, length)) for name in names],
                "bit_end": draw(st.sampled_from(["guided", "pinned", "sliding", "free"])),
            },
            "hole": {"radius": hole, "inclination": draw(between(0.0, 3.14))},
            "rig": {
                "weight_on_bit": draw(set_points(min(1e8, 0.03 * weakest))),
                "rotation": draw(set_points(600.0)),
                "duration": draw(between(1e-3, 1e6)),
            },
            "effects": effects,
            "numerics": {
                "elements": draw(st.just("auto") | st.integers(4, 4000)),
                "step": draw(st.just("auto") | between(1e-9, 1e-4)),
                "frame_rate": draw(between(1.0, 2000.0)),
                "seed": draw(st.integers(0, 2**63 - 1)),
            },
        }
    )  # fmt: skip


@st.composite
def marks(draw: st.DrawFn, name: str, length: float) -> dict[str, Any]:
    place = draw(between(0.0, 1.0)) * length
    return {"name": name, "distance_from_bit": place, "on": draw(st.sampled_from(["wall", "centre"]))}


@st.composite
def sections_in(draw: st.DrawFn, hole: float) -> dict[str, Any]:
    outer = draw(between(1e-4, 2.0 * hole, exclude_max=True))
    return {
        "name": draw(LABELS),
        "length": draw(between(1e-3, 5e3)),
        "outer_diameter": outer,
        "inner_diameter": draw(between(0.0, outer, exclude_max=True)),
        "youngs_modulus": draw(between(1e3, 1e13)),
        "poisson_ratio": draw(between(-1.0, 0.5, exclude_min=True)),
        "density": draw(between(1.0, 30000.0)),
    }


@st.composite
def set_points(draw: st.DrawFn, largest: float) -> dict[str, Any]:
    if draw(st.booleans()):
        return {"value": draw(between(-largest, largest))}
    return {
        "shape": draw(st.sampled_from(["step", "ramp"])),
        "initial": draw(between(-largest, largest)),
        "value": draw(between(-largest, largest)),
        "start": draw(between(0.0, 1e6)),
        "duration": draw(between(0.0, 1e6)),
    }


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(scenes())
def test_a_scene_reads_back_equal(scene):
    assert parse_scene(scene.to_yaml()) == scene


def test_the_text_says_the_si_unit_of_every_quantity(good):
    text = parse_scene(good).to_yaml()
    for line in (
        "outer_diameter: 0.0165 m",
        "density: 1100.0 kg/m^3",
        "value: 40.0 N",
        "stiffness: 10000000.0 N/m^2.5",
    ):
        assert line in text


def test_the_block_about_the_run_is_left_aside(good):
    scene = parse_scene(good)
    assert parse_scene(scene.to_yaml() + "run:\n  version: 0.1.0\n  step_s: 0.001\n") == scene


def test_in_code_plain_floats_are_si_and_still_checked():
    assert Gravity(magnitude=1.6).magnitude == 1.6
    with pytest.raises(ValidationError, match="expected an acceleration"):
        Gravity(magnitude=-1.0)
    with pytest.raises(ValidationError, match="finite"):
        Gravity(magnitude=float("nan"))


def test_a_scene_cannot_be_changed(good):
    scene = parse_scene(good)
    with pytest.raises(ValidationError, match="frozen"):
        scene.hole.radius = 1.0


def test_the_mark_table_knows_radius_and_clearance(good):
    low, high = parse_scene(good).mark_table
    assert (low.name, low.on, low.wall_offset, low.clearance) == ("low", "wall", 0.00825, pytest.approx(0.08175))
    assert (high.name, high.on, high.wall_offset, high.distance_from_bit) == ("high", "centre", 0.0, 4.4)


def test_a_place_belongs_to_its_section():
    sections = [
        {"length": 1.0, "outer_diameter": 0.1, "youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1000.0},
        {"length": 2.0, "outer_diameter": 0.2, "youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1000.0},
    ]
    scene = Scene.model_validate(
        {
            "name": "two",
            "string": {"sections": sections},
            "hole": {"radius": 0.5},
            "rig": {"duration": 1.0},
            "effects": {"stretch": {}, "torsion": {}},
        }
    )
    assert [scene.outer_radius_at(s) for s in (-1.0, 0.0, 0.99, 1.0, 3.0, 9.0)] == [0.05, 0.05, 0.05, 0.1, 0.1, 0.1]
    assert scene.length == 3.0
