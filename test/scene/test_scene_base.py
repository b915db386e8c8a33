# SPDX-License-Identifier: Apache-2.0
"""A scene with a `base` writes only what is different; mistakes are told where they are written."""

import pytest

from drill_twin.core.errors import SceneError
from drill_twin.scene import load_scene, parse_scene


def written(tmp_path, text, name="child.yaml"):
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return file


def test_blocks_are_filled_in_key_by_key_and_lists_are_whole(tmp_path):
    text = "base: pa6_bench\nname: child\nrig: {weight_on_bit: {value: 60 N}}\neffects: {bow: off}\n"
    marks = "string: {marks: [{name: only, distance_from_bit: 1 m}]}\n"
    child, base = load_scene(written(tmp_path, text + marks)), load_scene("pa6_bench")
    assert (child.name, child.rig.weight_on_bit.value) == ("child", 60.0)
    assert child.rig.weight_on_bit.duration == base.rig.weight_on_bit.duration
    assert child.effects.bow is None
    assert child.string.sections == base.string.sections
    assert [mark.name for mark in child.string.marks] == ["only"]
    assert load_scene(written(tmp_path, text), overrides={"wob": "70"}).rig.weight_on_bit.value == 70.0


def test_a_base_may_have_a_base_and_be_a_file_beside_it(tmp_path):
    written(tmp_path, "base: pa6_bench\nhole: {radius: 80 mm}\n", "middle.yaml")
    child = load_scene(written(tmp_path, "base: middle.yaml\nname: child\n"))
    assert (child.hole.radius, child.name) == (0.08, "child")


def test_a_mistake_is_told_in_the_file_that_has_it(tmp_path):
    with pytest.raises(SceneError, match=r"child\.yaml:2: hole\.radius"):
        load_scene(written(tmp_path, "base: pa6_bench\nhole: {radius: 90 kg}\n"))
    written(tmp_path, "base: pa6_bench\n\nhole: {radius: 90 kg}\n", "middle.yaml")
    with pytest.raises(SceneError, match=r"middle\.yaml:3: hole\.radius"):
        load_scene(written(tmp_path, "base: middle.yaml\n"))


def test_a_record_takes_the_place_of_a_set_point_of_the_base(tmp_path):
    (tmp_path / "record.csv").write_text("time,wob\n0,0\n1,10\n2,20\n")
    table = "table: {file: record.csv, time: {column: time, unit: s}, weight_on_bit: {column: wob, unit: N}}"
    head = "base: pa6_bench\nname: child\nrig:\n  weight_on_bit:\n"
    with pytest.raises(SceneError) as caught:
        load_scene(written(tmp_path, f"{head}    shape: table\n  {table}\n"))
    assert [problem.split(": ")[1] for problem in caught.value.problems] == [
        f"rig.weight_on_bit.{key}" for key in ("value", "duration")
    ]
    for problem in caught.value.problems:  # where the base wrote it, and where it was changed
        assert "pa6_bench.yaml:" in problem
        assert "child.yaml:4)" in problem
        assert ": ~` takes away the value of the base" in problem
    child = load_scene(written(tmp_path, f"{head}    {{shape: table, value: ~, duration: null}}\n  {table}\n"))
    assert child.rig.weight_on_bit.shape == "table"
    assert child.rig.table.file == str(tmp_path / "record.csv")


def test_a_key_without_a_value_removes_that_of_the_base(tmp_path):
    text = (
        "base: middle.yaml\nrig: {table: ~, weight_on_bit: {shape: constant, value: 3 N, duration: ~}}\nnumerics: ~\n"
    )
    text += "effects: {bow: {angle: ~}, gravity: }\n"
    middle = "base: pa6_bench\neffects: {bow: {angle: 30 deg}, gravity: off}\nnumerics: {frame_rate: 50 Hz}\n"
    middle += "rig: {table: {file: record.csv}}\n"
    written(tmp_path, middle, "middle.yaml")
    child = load_scene(written(tmp_path, text))
    assert child.rig.table is None
    assert child.numerics.frame_rate == 100.0
    assert child.effects.bow.angle == 0.0
    assert child.effects.gravity is not None  # an effect without a block is on
    with pytest.raises(SceneError, match=r"child\.yaml:2: hole\.radius: expected a length .*found nothing"):
        load_scene(written(tmp_path, "base: pa6_bench\nhole: {radius: ~}\n"))


def test_an_empty_override_removes_a_key():
    scene = load_scene("pa6_bench", overrides={"rig.weight_on_bit.duration": "~", "rig.weight_on_bit.shape": "null"})
    assert (scene.rig.weight_on_bit.shape, scene.rig.weight_on_bit.duration) == ("constant", 0.0)


def test_a_base_that_leads_nowhere_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"child\.yaml:1: base: .*no such scene"):
        load_scene(written(tmp_path, "base: nothing\n"))
    with pytest.raises(SceneError, match="base: expected the name or the file of a scene, found 3"):
        load_scene(written(tmp_path, "base: 3\n"))
    with pytest.raises(SceneError, match="at most 8 scenes"):
        load_scene(written(tmp_path, "base: child.yaml\n"))


def test_a_table_lies_beside_the_file_that_names_it(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "jumps.csv").write_text("time,wob\n0,0\n1,300\n2,0\n")
    table = "{file: jumps.csv, time: {column: time, unit: s}, weight_on_bit: {column: wob, unit: N}}"
    weight = "weight_on_bit: {shape: table, value: ~, duration: ~}"
    far = written(tmp_path / "far", f"base: pa6_bench\nname: jumps\nrig: {{{weight}, table: {table}}}\n", "jumps.yaml")
    assert load_scene(far).rig.table.file == str(tmp_path / "far" / "jumps.csv")
    child = load_scene(written(tmp_path, "base: far/jumps.yaml\n"))
    assert child.rig.table.file == load_scene(far).rig.table.file


def test_the_resolved_scene_stands_alone():
    scene = load_scene("pa6_calibrated")
    assert "base" not in scene.to_yaml()
    assert parse_scene(scene.to_yaml()) == scene


def test_a_start_off_the_axis_must_be_in_the_hole():
    assert load_scene("pa6_bench", overrides={"effects.lateral_kick": "{velocity: 0 m/s, offset: -85 mm}"})
    with pytest.raises(SceneError, match=r"lateral_kick\.offset: expected at most .*0\.09 m.*found 0\.095 m"):
        load_scene("pa6_bench", overrides={"effects.lateral_kick": "{velocity: 0 m/s, offset: 95 mm}"})
