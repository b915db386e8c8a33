# SPDX-License-Identifier: Apache-2.0
"""The exported schema is current, and an editor that uses it accepts good scenes and marks mistakes."""

import jsonschema
import pytest

from drill_twin.scene import config_dir, presets, scene_json_schema, scene_path, well_scenes
from drill_twin.scene.json_schema import schema_text
from drill_twin.scene.lines import read_lines


@pytest.fixture(scope="module")
def editor() -> jsonschema.Draft7Validator:
    schema = scene_json_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def test_the_exported_file_is_current():
    file = config_dir() / "schema" / "scene.schema.json"
    assert file.read_text(encoding="utf-8") == schema_text(), (
        "refresh it: python -c 'from drill_twin.scene.json_schema import schema_text as s; print(s(), end=\"\")' "
        f"> {file.relative_to(config_dir().parent)}"
    )


@pytest.mark.parametrize("name", [*presets(), *well_scenes()])
def test_installed_scenes_are_right_in_the_editor(editor, name):
    data = read_lines(scene_path(name).read_text(encoding="utf-8"), name).data
    assert [error.message for error in editor.iter_errors(data)] == []


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("16.5 mm", "16.5 kg", ["string", "sections", 0, "outer_diameter"]),
        ("16.5 mm", "16.5", ["string", "sections", 0, "outer_diameter"]),
        ("16.5 mm", "-16.5 mm", ["string", "sections", 0, "outer_diameter"]),
        ("outer_diameter", "outer_diametre", ["string", "sections", 0]),
        ("0.394", "0.6", ["string", "sections", 0, "poisson_ratio"]),
        ("2 rev/s", "2 Hz", ["rig", "rotation", "value"]),
        ("value: 40 N, ", "", ["rig", "weight_on_bit"]),
        ("shape: ramp", "shape: RAMP", ["rig", "rotation", "shape"]),
        ("on: centre", "on: middle", ["string", "marks", 1, "on"]),
        ("  torsion: {}\n", "", ["effects"]),
        ("bow:", "boww:", ["effects"]),
        ("frame_rate: 100 Hz", "elements: 2", ["numerics", "elements"]),
        ("hole:\n  radius: 90 mm\n", "", []),
    ],
)
def test_the_editor_marks_a_mistake_where_it_is(editor, good, old, new, place):
    data = read_lines(good.replace(old, new, 1), "x.yaml").data
    assert place in [list(error.absolute_path) for error in editor.iter_errors(data)]


def test_the_editor_accepts_what_the_twin_accepts(editor, good):
    for old, new in (
        ("gravity: {}", "gravity:"),
        ("gravity: {}", "gravity: off"),
        ("90 mm", "3 1/2 in"),
        ("1.10 g/cm^3", "68 lb/ft^3"),
        ("frame_rate: 100 Hz", "step: auto\n  elements: 80"),
        ("1e7 N/m^2.5", "1e7 N/m^2.5, restitution: 50 %"),
        ("{shape: step, value: 40 N, duration: 15 s}", "{shape: table}"),
    ):
        data = read_lines(good.replace(old, new, 1), "x.yaml").data
        assert [error.message for error in editor.iter_errors(data)] == [], new


def test_every_value_is_explained(editor):
    for name, block in editor.schema["definitions"].items():
        for key, field in block["properties"].items():
            assert field.get("description"), f"{name}.{key}"
            if "examples" in field:
                assert "[" in field["description"], f"{name}.{key} does not say its SI unit"
