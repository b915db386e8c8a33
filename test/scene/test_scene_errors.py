# SPDX-License-Identifier: Apache-2.0
"""Each mistake in a scene is one line: file, line, key, what was expected, what was found."""

import pytest
from pydantic import ValidationError

from drill_twin.core.errors import SceneError
from drill_twin.scene.blocks.string import String

CASES = [
    # old, new, line, what the message must say
    ("16.5 mm", "16.5 kg", 5, '.outer_diameter: expected a length such as "16.5 mm", found "16.5 kg" (mass)'),
    ("16.5 mm", "16.5", 5, 'outer_diameter: expected a length such as "16.5 mm", found 16.5 (no unit)'),
    ("16.5 mm", "16.5 mn", 5, '"mn" is not a known unit, did you mean "m"?'),
    ("16.5 mm", "-16.5 mm", 5, 'expected a length, above 0 m and at most 5 m, found "-16.5 mm"'),
    ("16.5 mm", "0 mm", 5, "above 0 m"),
    ("16.5 mm", ".nan", 5, "found nan"),
    ("16.5 mm", ".inf", 5, "found inf"),
    ("16.5 mm", "nan mm", 5, 'found "nan mm"'),
    ("16.5 mm", "", 5, "found nothing"),
    ("16.5 mm", "[1, 2]", 5, "found [1, 2]"),
    ("16.5 mm", "yes", 5, "found True"),
    ("outer_diameter", "outer_diametre", 5, 'found "outer_diametre", did you mean "outer_diameter"?'),
    ("      outer_diameter: 16.5 mm\n", "", 4, "found nothing (the key is required)"),
    ("16.5 mm", "190 mm", 5, "expected less than the diameter of the hole (0.18 m), found 0.19 m"),
    ("16.5 mm", "16.5 mm\n      inner_diameter: 2 cm", 6, "less than the outer diameter (0.0165 m), found 0.02"),
    ("0.394", "0.6", 7, "at most 0.5"),
    ("0.394", "-1", 7, "above -1"),
    ("0.394", "0.394 m", 7, 'found "0.394 m" (length)'),
    ("1.10 g/cm^3", "1e9 kg/m^3", 8, "osmium"),
    ("distance_from_bit: 4.4 m", "distance_from_bit: 44 m", 11, 'expected "high" on the string (5 m long), found 44 m'),
    ("name: high", "name: low", 11, 'found "low" again'),
    ("name: high", "name: high/1", 11, "expected letters, digits and underscores"),
    ("on: centre", "on: center", 11, 'expected one of wall, centre, found "center", did you mean "centre"?'),
    ("bit_end: sliding", "bit_end: slidng", 12, 'did you mean "sliding"?'),
    ("radius: 90 mm", "radius: 90 N", 14, "hole.radius: expected a length"),
    ("16.5 mm", '16.5 mm\n      name: "a\\e[31m"', 6, r"name: expected a name of printable characters"),
    ("hole:\n  radius: 90 mm", "hole: 90 mm", 13, "hole: expected a block with the keys radius, inclination"),
    ("hole:\n  radius: 90 mm\n", "", 1, "the keys radius, inclination, intervals, survey, found nothing"),
    ("rig:", "rigg:", 15, 'found "rigg", did you mean "rig"?'),
    ("value: 40 N", "value: 40 rev/s", 16, "rig.weight_on_bit.value: expected a force"),
    ("value: 40 N, ", "", 16, 'rig.weight_on_bit.value: expected a force such as "40 N", found nothing'),
    ("value: 40 N", "value: 1e12 N", 16, "at most 100 MN"),
    ("value: 2 rev/s", "value: 2 Hz", 17, 'found "2 Hz" (frequency)'),
    ("value: 2 rev/s", "value: 101 rev/s", 17, "no rig turns faster"),
    ("shape: ramp", "shape: constant", 17, 'expected no `duration` with shape "constant"'),
    ("shape: step", "shape: STEP", 16, 'did you mean "step"?'),
    ("{shape: step, value: 40 N, duration: 15 s}", "{shape: table}", 16, "expected `rig.table`"),
    ("duration: 30 s", "duration: 0 s", 18, "above 0 s"),
    ("bow: {amplitude: 2 mm}", "bow: {amplitude: 90 mm}", 23, "less than the clearance in the hole (0.08175 m)"),
    ("bow: {amplitude: 2 mm}", "bow:", 23, "effects.bow.amplitude: expected a length"),
    ("bow: {amplitude: 2 mm}", "bow: 2 mm", 23, "effects.bow: expected a block with the keys amplitude, shape, angle"),
    ("bow:", "boww:", 23, 'did you mean "bow"?'),
    ("offset: 0.1 mm", "offset: 10 mm", 24, "expected less than the outer radius (0.00825 m), found 0.01 m"),
    ("  wall: {stiffness: 1e7 N/m^2.5}\n", "", 25, "effects.wall_friction: expected `wall` to be listed too"),
    ("  torsion: {}\n", "", 21, "expected both or neither of `stretch` and `torsion`, found no `torsion`"),
    ("  stretch: {}\n", "", 21, "found no `stretch`"),
    ("coefficient: 0.1}", "coefficient: 1}\n  bit_friction: {coefficient: 1, radius: 1 m}", 27, "at most the radius"),
    ("frame_rate: 100 Hz", "elements: 3", 28, "numerics.elements: expected a number of elements"),
    ("frame_rate: 100 Hz", "elements: 80.5", 28, "found 80.5"),
    ("frame_rate: 100 Hz", "elements: many", 28, 'found "many"'),
    ("frame_rate: 100 Hz", "step: 20 ms", 28, "at most the time between frames (0.01 s), found 0.02 s"),
    ("frame_rate: 100 Hz", "scheme: euler", 28, "expected one of midpoint"),
    ("frame_rate: 100 Hz", "seed: -1", 28, "expected a whole number"),
    ("1e7 N/m^2.5", "1e7 N/m^2.5, restitution: yes", 25, "found True"),
    ("name: small\n", "", 1, "name: expected text, found nothing (the key is required)"),
    ("name: small", "name: 5", 1, "name: expected text, found 5"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "line", "words"), CASES, ids=[f"{new[:30]}@{line}" for _, new, line, _ in CASES]
)
def test_a_mistake_names_file_line_expected_and_found(refusal, old, new, line, words):
    message = refusal(old, new)
    assert message.startswith(f"x.yaml:{line}: ")
    assert words in message


def test_a_load_that_no_string_carries_is_refused_with_the_numbers(refusal):
    message = refusal("value: 40 N", "value: 30 kN")
    assert "rig.weight_on_bit.value: expected at most 2.458e+04 N, found 3e+04 N" in message
    assert "E A = 4.918e+05 N) by 6.1 %" in message


def test_a_bit_held_on_the_axis_cannot_rub_sideways(refusal, changed):
    added = "coefficient: 0.1}\n  bit_friction: {coefficient: 0.2, radius: 8 mm}"
    message = refusal("coefficient: 0.1}", added, {"string.bit_end": "guided"})
    assert "effects.bit_friction: expected `string.bit_end` to be sliding or free, found guided" in message
    without = added.replace("0.2", "0")
    assert changed("coefficient: 0.1}", without, {"string.bit_end": "guided"}).effects.bit_friction.coefficient == 0.0


def test_a_string_is_not_longer_than_the_longest_well():
    section = {"length": 12e3, "outer_diameter": 0.1, "youngs_modulus": 2e11, "poisson_ratio": 0.3, "density": 7850.0}
    with pytest.raises(ValidationError, match="expected at most 20 km in all, found 24 km"):
        String.model_validate({"sections": [section, section]})


def test_the_first_of_several_mistakes_is_told_and_the_others_counted(refusal):
    message = refusal("16.5 mm\n      youngs_modulus: 2.3 GPa", "16.5 kg\n      youngs_modulus: 2.3 kg")
    assert message.startswith("x.yaml:5: ")
    assert message.endswith("(and 1 more problem: see `drill-twin scene check`)")


def test_problems_between_parts_show_beside_those_of_fields(changed):
    bad = "bow: {amplitude: 95 mm}\n  bit_friction: {coefficient: 9, radius: 8 mm}"
    with pytest.raises(SceneError) as caught:
        changed("bow: {amplitude: 2 mm}", bad, {"numerics.seed": "-1", "effects.wall": "off"})
    places = ["numerics.seed", "effects.bow.amplitude", "effects.bit_friction.coefficient", "effects.wall_friction"]
    assert len(caught.value.problems) == len(places)
    for place in places:
        assert any(f": {place}: " in problem for problem in caught.value.problems), place
    assert all("\n" not in problem for problem in caught.value.problems)


def test_an_invalid_part_hides_only_the_checks_that_need_it(changed):
    with pytest.raises(SceneError) as caught:
        changed("radius: 90 mm", "radius: 90 kg", {"effects.torsion": "off", "effects.bow.amplitude": "1 m"})
    assert [problem.split(": ")[1] for problem in caught.value.problems] == ["hole.radius", "effects.stretch"]


def test_a_sound_scene_is_not_refused(changed):
    assert changed().effect_names == ["bow", "eccentricity", "gravity", "stretch", "torsion", "wall", "wall_friction"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("value: 40 N", "value: -40 N"),  # pulling
        ("value: 2 rev/s", "value: -2 rev/s"),  # left-handed
        ("gravity: {}", "gravity:"),
        ("gravity: {}", "gravity: on"),
        ("1e7 N/m^2.5", "1e7 N/m^2.5, restitution: 50 %"),
        ("5 m\n", "5000 mm\n"),
        ("frame_rate: 100 Hz", "elements: auto\n  step: auto"),
        ("frame_rate: 100 Hz", "elements: 80\n  step: 1 ms"),
    ],
)
def test_what_looks_odd_but_is_meant_is_accepted(changed, old, new):
    changed(old, new)


def test_an_effect_can_be_written_off(changed):
    assert "gravity" not in changed("gravity: {}", "gravity: off").effect_names
    assert changed("gravity: {}", "gravity:").effects.gravity.magnitude == 9.81
