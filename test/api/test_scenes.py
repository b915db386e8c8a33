# SPDX-License-Identifier: Apache-2.0
"""Scenes from Python: the same scenes as from files, and errors in the same words."""

import math

import pytest

import drill_twin as dt

ROD = {
    "string": {
        "sections": [
            {
                "length": 5.0,
                "outer_diameter": "16.5 mm",
                "youngs_modulus": 2.3e9,
                "poisson_ratio": 0.394,
                "density": "1.10 g/cm^3",
            }
        ],
        "marks": ({"name": "middle", "distance_from_bit": "2500 mm"},),
    },
    "hole": {"radius": "90 mm"},
    "rig": {"weight_on_bit": {"value": 40}, "rotation": {"value": "120 rpm"}, "duration": "10 s"},
    "effects": {"gravity": True, "stretch": True, "torsion": {}, "bow": False},
}


def test_text_with_units_and_numbers_in_si_override_a_scene():
    scene = dt.load_scene("pa6_bench", {"rig.rotation.value": "120 rpm", "rig.weight_on_bit.value": 60})
    assert scene.rig.rotation.value == pytest.approx(4.0 * math.pi)
    assert scene.rig.weight_on_bit.value == 60.0
    assert dt.load_scene("pa6_bench", {"rpm": 120}) == dt.load_scene("pa6_bench", {"rpm": "2 rev/s"})
    assert dt.load_scene("pa6_bench", {"effects.wall.stiffness": 1e-05}).effects.wall.stiffness == 1e-05
    with pytest.raises(dt.SceneError, match="did you mean"):
        dt.load_scene("pa6_bench", {"rig.rotatoin.value": 3})
    with pytest.raises(dt.SceneError, match="expected a speed of rotation"):
        dt.load_scene("pa6_bench", {"rig.rotation.value": "3 kg"})


def test_no_override_changes_nothing():
    scene = dt.load_scene("bha_full_size")
    assert dt.override(scene, {}) == scene


def test_a_scene_is_built_from_blocks_with_units_or_si():
    scene = dt.build_scene("rod", **ROD)
    assert scene.length == 5.0
    assert scene.string.marks[0].distance_from_bit == 2.5
    assert scene.string.sections[0].density == 1100.0
    assert scene.rig.rotation.value == pytest.approx(4.0 * math.pi)
    assert scene.effect_names == ["gravity", "stretch", "torsion"]


def test_a_scene_is_built_on_another():
    scene = dt.build_scene("wide", base="pa6_bench", hole={"radius": 0.12})
    assert scene.hole.radius == 0.12
    assert scene.string == dt.load_scene("pa6_bench").string


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"hole": {"radius": "90 kg"}}, 'hole.radius: expected a length such as "16.5 mm"'),
        ({"hole": {"radius": -0.09}}, "above 0 m"),
        ({"hole": {"radiuss": 0.09}}, 'did you mean "radius"'),
        ({"hole": None}, "hole: expected a block"),
        ({"effects": {"gravitation": True}}, 'expected one of the keys .* found "gravitation"'),
    ],
)
def test_what_is_wrong_is_said_with_key_expected_and_found(change, words):
    with pytest.raises(dt.SceneError, match=words):
        dt.build_scene("rod", **(ROD | change))


def test_a_scene_is_written_and_read_again(tmp_path):
    scene = dt.build_scene("rod", **ROD)
    file = dt.write_scene(scene, tmp_path / "rod.yaml")
    assert dt.load_scene(file) == scene
    with pytest.raises(dt.SceneError, match="expected a new file"):
        dt.write_scene(scene, file)


def test_check_names_what_loading_does_not_see():
    assert dt.check_scene("pa6_bench") == []
    assert "expected the CSV, MAT, LAS or WITSML file" in dt.check_scene("ufrj_rig")[0]
    assert "no such scene file" in dt.check_scene("pa6_bensh")[0]
    assert {"pa6_bench", "two_mass"} <= set(dt.scene_names())
