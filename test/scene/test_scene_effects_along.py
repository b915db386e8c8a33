# SPDX-License-Identifier: Apache-2.0
"""Mistakes in the effects along the string: mud, imperfections, damping and forcing; each is one line."""

import pytest

from drill_twin.scene import parse_scene

MUD = "mud: {density: 1200 kg/m^3}"
NO_MUD = "expected `mud` to be listed too"
CASES = [
    # block(s), what the message must say
    ("mud:", "mud.density: expected a density"),
    ("mud: {density: 0 kg/m^3}", "above 0 kg/m^3 and at most 4000 kg/m^3 (the heaviest muds have 2700; air has 1.2)"),
    ("mud: {density: -1 g/cm^3}", 'found "-1 g/cm^3"'),
    ("mud: {density: 8000 kg/m^3}", "at most 4000 kg/m^3"),
    ("mud: {density: 1 g/cm^3, viscosity: -1 cP}", "expected a viscosity, at least 0 Pa s and at most 10 Pa s"),
    ("mud: {density: 1 g/cm^3, viscosity: 20 N}", 'expected a viscosity such as "0.02 Pa s", found "20 N" (force)'),
    ("mud: {density: 1 g/cm^3, inside: oil}", "expected one of mud, air"),
    ("quadratic_drag:", NO_MUD),
    ("added_mass:", NO_MUD),
    ("rotation_drag:", NO_MUD),
    (f"{MUD}\n  rotation_drag:", "rotation_drag: expected a viscosity above 0 Pa s in `mud`, found 0 Pa s"),
    ("viscous_drag:", NO_MUD),
    (f"{MUD}\n  quadratic_drag: {{coefficient: 11}}", "at most 10 (a cylinder has 0.3 to 2), found 11"),
    (f"{MUD}\n  added_mass: {{coefficient: -1}}", "at least 0"),
    (f"{MUD}\n  added_mass: {{confined: 1}}", "expected true or false, found 1"),
    ("eccentricity: {}", "expected an `offset`, `sections`, or a random `rms` above 0 m, found none"),
    ("eccentricity: {offset: 8.25 mm}", "expected less than the outer radius (0.00825 m), found 0.00825 m"),
    ("eccentricity: {offset: -1 mm}", "at least 0 m"),
    ("eccentricity: {offset: 1 mm, sections: [{offset: 1 mm}]}", "expected `offset` or `sections`, found both"),
    ("eccentricity: {sections: [{offset: 1 mm}, {offset: 1 mm}]}", "one item for each of the 1 sections"),
    ("eccentricity: {sections: [{offset: 1 cm}]}", "sections[0].offset: expected less than the outer radius"),
    ("eccentricity: {sections: [{angle: 1 rad}]}", "sections[0].offset: expected a length"),
    ("eccentricity: {rms: 1 mm}", "expected a `correlation_length` with `rms`, found none"),
    ("eccentricity: {offset: 1 mm, correlation_length: 1 m}", "expected an `rms` with `correlation_length`"),
    ("eccentricity: {rms: 9 mm, correlation_length: 1 m}", "eccentricity.rms: expected less than the outer radius"),
    ("eccentricity: {rms: 1 mm, correlation_length: 0 m}", "above 0 m and at most 20 km (the longest string)"),
    ("eccentricity: {rms: 1 mm, correlation_length: 1 m, seed: -1}", "expected a whole number from 0 to"),
    ("eccentricity: {rms: 1 mm, correlation_length: 1 m, seed: 1.5}", "found 1.5"),
    ("bow: {amplitude: 1 mm, shape: random}", 'expected a `correlation_length` with shape "random" and only there'),
    ("bow: {amplitude: 1 mm, correlation_length: 1 m}", 'found one with shape "half_wave"'),
    ("bow: {amplitude: -1 mm}", "at least 0 m"),
    ("internal_damping: {bending_time: -1 ms}", "at least 0 s and at most 10 s"),
    ("drag: {linear: 1 N}", 'expected a drag per length and speed such as "0.2 N s/m^2", found "1 N" (force)'),
    ("drag: {linear: -1 N s/m^2}", "at least 0 N s/m^2"),
    ("random_force: {rms: 1 N, correlation_time: 1 s, correlation_length: 1 m}", "expected a force per length"),
    ("random_force: {rms: -1 N/m, correlation_time: 1 s, correlation_length: 1 m}", "expected a force per length, at"),
    ("random_force: {rms: 1 N/m, correlation_time: 0 s, correlation_length: 1 m}", "correlation_time: expected a time"),
    ("random_force: {rms: 1 N/m, correlation_time: 1 s}", "correlation_length: expected a length"),
    ("top_shake: {amplitude: 1 mm}", "frequency: expected a frequency"),
    ("top_shake: {amplitude: 1 mm, frequency: 2 rpm}", 'found "2 rpm" (speed of rotation)'),
    ("top_shake: {amplitude: 82 mm, frequency: 2 Hz}", "less than the clearance in the hole (0.08175 m)"),
    ("top_shake: {amplitude: 1 mm, frequency: -2 Hz}", "at least 0 Hz"),
]  # fmt: skip


@pytest.mark.parametrize(("blocks", "words"), CASES, ids=[blocks for blocks, _ in CASES])
def test_a_mistake_is_one_line(refusal, good, blocks, words):
    key = blocks.split(":")[0]
    old = next((line for line in good.splitlines() if line.startswith(f"  {key}:")), "numerics:")
    message = refusal(old, f"  {blocks}" + ("\nnumerics:" if old == "numerics:" else ""))
    assert words in message
    assert message.startswith("x.yaml:2")


@pytest.mark.parametrize(
    "blocks",
    [
        "mud: {density: 10 ppg, viscosity: 20 cP, inside: air}\n  rotation_drag:\n  added_mass: {confined: true}",
        "eccentricity: {sections: [{offset: 1 mm, angle: 90 deg}]}",
        "eccentricity: {offset: 1 mm, rms: 1 mm, correlation_length: 2 m, seed: 7}",
        "bow: {amplitude: 1 mm, shape: random, correlation_length: 2 m}",
        "random_force: {rms: 0.5 N/m, correlation_time: 50 ms, correlation_length: 1 m}",
        "top_shake: {amplitude: 1 mm, frequency: 2 Hz, direction: 90 deg, bandwidth: 0.5 Hz}",
    ],
)
def test_what_is_meant_is_accepted_and_written_back(changed, good, blocks):
    key = blocks.split(":")[0]
    old = next((line for line in good.splitlines() if line.startswith(f"  {key}:")), "numerics:")
    scene = changed(old, f"  {blocks}" + ("\nnumerics:" if old == "numerics:" else ""))
    assert key in scene.effect_names
    assert parse_scene(scene.to_yaml(), name="again.yaml") == scene
