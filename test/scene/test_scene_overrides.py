# SPDX-License-Identifier: Apache-2.0
"""Values given beside the file take the place of its own, and are checked like them."""

import math
from pathlib import Path

import pytest

from drill_twin.core.errors import SceneError
from drill_twin.scene import load_scene


def test_a_key_with_dots_sets_one_value(changed):
    scene = changed(overrides={"rig.rotation.value": "50 rpm", "numerics.elements": "80", "numerics.step": "1 ms"})
    assert scene.rig.rotation.value == pytest.approx(50.0 * math.pi / 30.0)
    assert (scene.numerics.elements, scene.numerics.step) == (80, 0.001)


def test_short_names_take_bare_numbers_in_the_units_of_the_rig(changed):
    scene = changed(overrides={"wob": "60", "rpm": "-180", "duration": "5"})
    assert (scene.rig.weight_on_bit.value, scene.rig.duration) == (60.0, 5.0)
    assert scene.rig.rotation.value == pytest.approx(-6.0 * math.pi)
    assert changed(overrides={"wob": "6 kN"}).rig.weight_on_bit.value == 6e3


def test_a_bare_weight_is_refused_where_field_units_are_meant(changed):
    scene = changed(overrides={"units": "field", "wob": "0.1 klbf"})
    assert scene.rig.weight_on_bit.value == pytest.approx(444.8, abs=0.1)
    with pytest.raises(SceneError, match=r'wob: expected a weight on bit with its unit .*"25 klbf", found "25"'):
        changed(overrides={"units": "field", "wob": "25"})
    none = changed(overrides={"units": "field", "wob": "0", "rpm": "0"}).rig
    assert (none.weight_on_bit.value, none.rotation.value) == (0.0, 0.0)


def test_items_of_a_list_are_named_by_number_or_name(changed):
    scene = changed(
        overrides={"string.marks.low.on": "centre", "string.marks[1].on": "wall", "string.sections[0].length": "6 m"}
    )
    assert [mark.on for mark in scene.string.marks] == ["centre", "wall"]
    assert scene.length == 6.0


def test_effects_are_taken_out_and_put_in(changed):
    scene = changed(
        overrides={"effects.bow": "off", "effects.lateral_kick.velocity": "1 m/s", "effects.drag.linear": "1 N s/m^2"}
    )
    assert "bow" not in scene.effect_names
    assert scene.effects.lateral_kick.velocity == 1.0
    assert scene.effects.drag.linear == 1.0


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (
            {"rig.rotation.value": "50 kg"},
            'rig.rotation.value: expected a speed of rotation such as "2 rev/s", found "50 kg"',
        ),
        ({"rig.rotation.value": "50"}, "found 50 (no unit)"),
        ({"rig.rotationn.value": "50 rpm"}, 'did you mean "rotation"?'),
        ({"wob": "nan"}, 'found "nan"'),
        ({"wob": "-12 klb"}, "wob: expected a weight on bit from 0, found -12 klb; a bit that is pulled"),
        ({"wob": -40.0}, "wob: expected a weight on bit from 0, found -40.0"),
        ({"rpm": "many"}, 'found "many"'),
        ({"duration": "-3"}, "above 0 s"),
        ({"": "x"}, 'expected a key such as "rig.duration"'),
        ({"...": "x"}, "expected a key such as"),
        ({"string.sections.3.length": "2 m"}, "found no `3`"),
        ({"string.marks.middle.on": "wall"}, "found no `middle`"),
        ({"rig.rotation.value.x": "1"}, "found no `x`"),
        ({"rig.rotation.value": "{"}, "found '{'"),
        ({"effects.bow.amplitud": "3 mm"}, 'did you mean "amplitude"?'),
        ({"hole.radius": ""}, "found nothing"),
        ({"numerics": "5"}, "numerics: expected a block"),
        ({"effects.wall": "off"}, "wall_friction needs wall"),
    ],
)
def test_a_wrong_override_is_named_as_one(refusal, overrides, words):
    message = refusal(overrides=overrides)
    assert words in message
    if "needs" not in words:
        assert message.startswith("x.yaml: override: ")


def test_overrides_do_not_stick_to_the_file(changed):
    changed(overrides={"wob": "60"})
    assert changed().rig.weight_on_bit.value == 40.0


def test_a_table_file_counts_from_the_scene_or_from_where_the_user_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, good: str
):
    (tmp_path / "scenes").mkdir()
    scene = tmp_path / "scenes" / "mine.yaml"
    scene.write_text(good.replace("  duration: 30 s", "  duration: 30 s\n  table: {file: data/record.csv}"))
    monkeypatch.chdir(tmp_path)
    assert load_scene(scene).rig.table.file == str(tmp_path / "scenes/data/record.csv")
    assert load_scene(scene, overrides={"rig.table.file": "record.csv"}).rig.table.file == str(tmp_path / "record.csv")


def test_a_value_that_is_no_yaml_is_refused(good):
    with pytest.raises(SceneError, match=r"override: numerics\.seed: expected a value"):
        load_scene("pa6_bench", overrides={"numerics.seed": "[1"})


def test_newton_is_asked_for_more_where_nothing_takes_energy():
    assert load_scene("pa6_bench").tolerance == 1e-5
    losing = ("internal_damping", "drag", "wall_friction", "bit_friction")
    free = {f"effects.{name}": "off" for name in (*losing, "wall")}
    assert load_scene("pa6_bench", overrides=free).tolerance == 1e-6
    assert load_scene("pa6_bench", overrides=free | {"numerics.tolerance": "1e-4"}).tolerance == 1e-4
