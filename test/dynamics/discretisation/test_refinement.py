# SPDX-License-Identifier: Apache-2.0
"""Graded mesh of long strings: fine in the assembly, coarse in hanging pipe; short strings are meshed by length."""

import math

import numpy as np
import pytest

from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.discretisation.notes import notes_on
from drill_twin.dynamics.discretisation.resolution import (
    LONGEST_ELEMENT,
    PER_WAVE,
    elements_needed,
    mesh,
    resolution_of,
)
from drill_twin.physics.model.mesh import build_rod
from drill_twin.scene import load_scene

WHOLE = {"numerics.lateral_from": "0 m"}
BARE = {f"effects.{name}": "off" for name in ("mud", "added_mass", "quadratic_drag", "rotation_drag", "viscous_drag")}


def test_short_strings_are_meshed_by_length() -> None:
    scene = load_scene("bha_full_size")
    for one, other in zip(mesh(scene, 90), build_rod(tubes_of(scene), 90), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("elements", [50, 300, 777])
def test_a_graded_mesh_has_its_elements_and_every_change_of_section_on_a_node(elements: int) -> None:
    scene = load_scene("wells/vertical_3000", overrides=WHOLE)
    rod = mesh(scene, elements)
    assert rod.length.size == elements
    assert rod.arc[-1] == pytest.approx(3000.0)
    tops = np.cumsum([section.length for section in scene.string.sections])
    assert np.abs(rod.arc[:, None] - tops).min(axis=0) == pytest.approx(0.0, abs=1e-9)
    uniform = build_rod(tubes_of(scene), elements)
    pipe = (rod.arc[:-1] > 500.0, uniform.arc[:-1] > 500.0)
    assert rod.length[pipe[0]].min() > uniform.length[pipe[1]].max()
    assert math.fsum(rod.line_mass * rod.length) == pytest.approx(math.fsum(uniform.line_mass * uniform.length))


def test_auto_takes_what_the_rule_asks_for() -> None:
    for name in ("wells/vertical_3000", "wells/s_shaped"):
        scene = load_scene(name, overrides=WHOLE)
        assert resolution_of(scene)[0] == math.ceil(elements_needed(scene).sum()) < 400
    scene = load_scene("wells/extended_reach", overrides=WHOLE)
    assert resolution_of(scene)[0] == 1000
    (note,) = notes_on(scene)
    assert "takes 1000 elements, its most, where its rule (6 a bending wave" in note
    assert f"asks for {math.ceil(elements_needed(scene).sum())}: " in note


def test_six_elements_a_wave_at_the_frequency_of_rotation() -> None:
    """A pipe whose weight is nothing beside its bending: k^4 = m Omega^2 / EI."""
    one = {"length": "1200 m", "outer_diameter": "5 in", "inner_diameter": "4 in", "density": "7850 kg/m^3"}
    scene = load_scene(
        "wells/vertical_3000",
        overrides=BARE | {
            "effects.gravity": "off", "rig.weight_on_bit.value": "0 N",
            **{f"string.sections[6].{key}": value for key, value in one.items()},
            "string.sections[6].adjusted_mass": "40 kg/m", "rig.rotation.value": "300 rpm",
        },
    )  # fmt: skip
    section = scene.string.sections[-1]
    wave = (40.0 * (10.0 * math.pi) ** 2 / (section.youngs_modulus * section.second_moment)) ** 0.25
    assert elements_needed(scene)[-1] == pytest.approx(1200.0 * PER_WAVE * wave / math.tau, rel=1e-2)


def test_no_element_is_longer_than_half_a_stand() -> None:
    still = load_scene(
        "wells/vertical_3000", overrides={"rig.rotation.value": "0 rpm", "rig.weight_on_bit.value": "0 N"}
    )
    assert elements_needed(still).sum() == pytest.approx(3000.0 / LONGEST_ELEMENT, rel=1e-6)
