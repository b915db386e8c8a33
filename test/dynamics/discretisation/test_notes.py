# SPDX-License-Identifier: Apache-2.0
"""Notes on scenes whose mesh is coarser than the rule asks for, or whose rotary drag takes much of the torque."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

from drill_twin.dynamics.discretisation import notes
from drill_twin.dynamics.discretisation.notes import frequency_error, notes_on
from drill_twin.dynamics.discretisation.resolution import resolution_of
from drill_twin.runs import RunLoop
from drill_twin.scene import load_scene, presets

LOADED = {"string.sections[1].length": "800 m", "rig.weight_on_bit.value": "800 kN"}
LONG = {"string.sections[1].length": "3420 m"}


@pytest.mark.parametrize("name", sorted(set(presets()) - {"ufrj_rig", "ufrj_torsion"}))
def test_the_installed_scenes_need_no_note(name):
    assert notes_on(load_scene(name)) == []


@pytest.mark.parametrize(("share", "told"), [(1.4, 0), (1.6, 1)])
def test_a_step_that_costs_little_more_is_not_told(monkeypatch, share, told):
    monkeypatch.setattr(notes, "step_of_motion", lambda _: 1e-3 * share)
    monkeypatch.setattr(notes, "stick_slip_step", lambda _: 1e-3)
    assert len(notes_on(load_scene("pa6_bench"))) == told


def test_a_mesh_at_the_cap_is_told_with_its_cost():
    scene = load_scene("bha_full_size", overrides=LOADED | {"effects.drag.rotary": "0 N s"})
    assert resolution_of(scene)[0] == 400
    (note,) = notes_on(scene)
    assert "`numerics.elements: auto` takes 400 elements" in note
    wanted = int(note.rsplit("numerics.elements: ", 1)[1].rstrip("`"))
    assert wanted > 400
    assert f"asks for {wanted}: " in note
    assert (
        notes_on(
            load_scene(
                "bha_full_size", overrides=LOADED | {"effects.drag.rotary": "0 N s", "numerics.elements": str(wanted)}
            )
        )
        == []
    )


@pytest.mark.parametrize("elements", [4, 8])
def test_the_error_told_is_that_of_cubic_elements(elements):
    """Bending waves of a periodic beam of unit EI and mass, against the frequency k^2."""
    h = math.tau / elements
    stiff = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                      [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]) / h**3  # fmt: skip
    mass = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                     [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]) * h / 420  # fmt: skip
    whole = np.zeros((2, 2 * elements, 2 * elements))
    for number in range(elements):
        at = np.ix_(*[[(2 * number + i) % (2 * elements) for i in range(4)]] * 2)
        whole[0][at] += stiff
        whole[1][at] += mass
    frequency = math.sqrt(eigh(whole[0], whole[1], eigvals_only=True)[1])
    assert frequency - 1.0 == pytest.approx(frequency_error(elements), rel=0.35)


def test_a_rotary_drag_copied_to_a_long_string_is_told():
    fine = {"numerics.elements": "1000", "rig.rotation.value": "120 rpm"}
    assert notes_on(load_scene("bha_full_size", overrides=fine)) == []
    (note,) = notes_on(load_scene("bha_full_size", overrides=LONG | fine))
    assert "takes 9.048 kN m from the top drive at 120 rpm over 3600 m" in note


def test_notes_are_in_the_diagnostics():
    below = {"effects.wall_friction.intervals": "[{top: 20 m, bottom: 30 m, coefficient: 0.2}]"}
    loop = RunLoop(load_scene("pa6_bench", overrides=below), 0.01, lambda *_: None)
    assert loop.diagnostics()["notes"].startswith("`effects.wall_friction.intervals[0]` begins at 20 m, below the bit")


def test_friction_of_an_interval_below_the_bit_is_told():
    cased = "effects.wall_friction.intervals"
    near = {cased: "[{top: 2 m, bottom: 20 m, coefficient: 0.1}, {top: 20 m, bottom: 30 m, coefficient: 0.2}]"}
    (note,) = notes_on(load_scene("pa6_bench", overrides=near))
    assert note == f"`{cased}[1]` begins at 20 m, below the bit at 5 m: no part of the string is in it"


def test_rolling_that_frames_or_steps_cannot_show_is_told():
    """Radius over clearance times 2 rev/s: 0.1539875 / (0.155575 - 0.1539875) = 97, 194 Hz.

    A run tells it of a blade with a mark once the mark whirls; without friction nothing rolls.
    """
    whole = {"numerics.lateral_from": "0 m"}
    bare = {"string.marks": "[{name: collars, distance_from_bit: 100 m}]"} | whole
    (note,) = notes_on(load_scene("wells/vertical_3000", overrides=bare))
    assert notes_on(load_scene("wells/vertical_3000", overrides=whole)) == []
    assert notes_on(load_scene("wells/vertical_3000", overrides=bare | {"effects.wall_friction": "off"})) == []
    assert (
        "near-bit stabiliser, 1.5 m from the bit, whirls at -97 times the rotation (radius over clearance), 194 Hz"
        in note
    )
    assert "this needs 485 Hz; a step of 5 ms, this needs a step of 0.258 ms; so for 4 m of the string" in note
    wide = {"string.sections[1].blade_diameter": "280 mm", "string.sections[3].blade_diameter": "280 mm"}
    fine = {"numerics.frame_rate": "200 Hz", "numerics.step": "2 ms"}
    assert notes_on(load_scene("wells/vertical_3000", overrides=bare | wide | fine)) == []
