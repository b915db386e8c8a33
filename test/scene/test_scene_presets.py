# SPDX-License-Identifier: Apache-2.0
"""The installed scenes hold the numbers they claim."""

import math
import shutil
from pathlib import Path

import pytest

from drill_twin.core.errors import SceneError
from drill_twin.scene import config_dir, load_scene, parse_scene, presets, scene_path

NAMES = (
    "bha_full_size", "bha_stress", "pa6_bench", "pa6_calibrated", "rotor_kit", "two_mass", "ufrj_rig", "ufrj_torsion",
    "well_b",
)  # fmt: skip


def test_all_scenes_are_installed_under_their_names():
    assert tuple(presets()) == NAMES
    assert (config_dir() / "scenes").is_dir()


@pytest.mark.parametrize("name", NAMES)
def test_an_installed_scene_loads_and_survives_being_written(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.description
    assert scene.provenance
    assert parse_scene(scene.to_yaml()) == scene


@pytest.mark.parametrize("name", NAMES)
def test_an_installed_scene_points_its_editor_at_the_schema(name):
    first = scene_path(name).read_text().splitlines()[0]
    assert first.startswith("# yaml-language-server: $schema=")
    assert (scene_path(name).parent / first.partition("=")[2]).resolve().is_file()


def test_pa6_bench_holds_tables_1_and_2_of_the_paper():
    scene = load_scene("pa6_bench")
    (rod,) = scene.string.sections
    assert (rod.length, rod.outer_diameter, rod.inner_diameter) == (5.0, 0.0165, 0.0)
    assert (rod.youngs_modulus, rod.poisson_ratio, rod.density) == (2.3e9, 0.394, 1100.0)
    assert scene.hole.radius == 0.09
    assert scene.clearance_at(2.5) == pytest.approx(0.08175)
    assert [(mark.name, mark.distance_from_bit, mark.on) for mark in scene.string.marks] == [
        ("mark_1", 4.4, "wall"),
        ("mark_2", 2.5, "wall"),
        ("mark_3", 0.5, "wall"),
        ("mark_4", 0.5, "centre"),
    ]
    assert scene.rig.weight_on_bit.value == 40.0
    assert scene.rig.rotation.value == pytest.approx(4.0 * math.pi)
    assert scene.rig.duration == 30.0


def test_pa6_bench_has_the_stiffness_and_mass_computed_for_the_rod():
    (rod,) = load_scene("pa6_bench").string.sections
    assert rod.youngs_modulus * rod.second_moment == pytest.approx(8.368, rel=1e-4)
    assert rod.youngs_modulus * rod.area == pytest.approx(4.918e5, rel=1e-4)
    assert rod.shear_modulus * 2.0 * rod.second_moment == pytest.approx(6.003, rel=1e-4)
    assert rod.mass_per_length == pytest.approx(0.2352, rel=1e-4)


def test_bha_is_a_stand_in_with_the_sizes_asked_for():
    scene = load_scene("bha_full_size")
    assert "stand-in" in scene.provenance.lower()
    assert scene.length > 475.0
    assert scene.hole.radius * 2.0 == pytest.approx(12.25 * 0.0254)
    assert [section.outer_diameter for section in scene.string.sections] == pytest.approx([0.2032, 0.1397])
    assert [mark.distance_from_bit for mark in scene.string.marks] == [22.6, 475.0]
    assert scene.string.section_at(22.6).name == "collars"
    assert scene.string.section_at(475.0).name == "pipe"
    assert scene.rig.weight_on_bit.value == 160e3
    assert scene.rig.rotation.value == pytest.approx(50.0 * math.pi / 30.0)


def test_the_lab_rig_twists_at_the_frequency_of_its_record_and_carries_its_load():
    scene = load_scene("ufrj_rig")
    assert "estimated" in scene.provenance.lower()
    *low, shaft = scene.string.sections
    stiffness = shaft.shear_modulus * 2.0 * shaft.second_moment / shaft.length
    inertia = sum(part.density * 2.0 * part.second_moment * part.length for part in low)
    inertia += shaft.density * 2.0 * shaft.second_moment * shaft.length / 3.0
    assert math.sqrt(stiffness / inertia) / (2.0 * math.pi) == pytest.approx(2.7, abs=0.03)
    largest_recorded = 743.0
    assert 2.045 * math.pi**2 * shaft.youngs_modulus * shaft.second_moment / shaft.length**2 > largest_recorded


def test_a_file_is_found_with_and_without_its_ending(tmp_path: Path):
    shutil.copy(scene_path("pa6_bench"), tmp_path / "mine.yaml")
    assert load_scene(tmp_path / "mine.yaml") == load_scene(tmp_path / "mine") == load_scene("pa6_bench")


def test_an_unknown_scene_names_the_installed_ones():
    for given, meant in (("pa6_bensh", "pa6_bench"), ("s_shaped", "wells/s_shaped")):
        with pytest.raises(SceneError, match="no such scene file") as caught:
            load_scene(given)
        assert f'did you mean "{meant}"?' in str(caught.value)
        assert ", ".join(NAMES) in str(caught.value)


def test_a_package_without_its_data_says_where_it_looked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr("drill_twin.scene.paths._candidates", lambda: [tmp_path])
    with pytest.raises(SceneError, match="expected the installed scenes") as caught:
        load_scene("pa6_bench")
    assert str(tmp_path) in str(caught.value)


def test_installed_scenes_are_found_through_the_ament_index(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """As `ros2 run` finds them: share/drill_twin of a colcon workspace."""
    pytest.importorskip("ament_index_python")
    marker = tmp_path / "share/ament_index/resource_index/packages/drill_twin"
    marker.parent.mkdir(parents=True)
    marker.touch()
    shutil.copytree(config_dir() / "scenes", tmp_path / "share/drill_twin/scenes")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.setattr("drill_twin.scene.paths.__file__", str(tmp_path / "lib/drill_twin/scene/paths.py"))
    assert config_dir() == tmp_path / "share/drill_twin"
    assert load_scene("pa6_bench").name == "pa6_bench"
