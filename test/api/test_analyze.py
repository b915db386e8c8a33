# SPDX-License-Identifier: Apache-2.0
"""Analysis of plain arrays: orbits whose onset, sense and frequency are known, and arrays that do not fit."""

import math

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.api.whirl import CLEARANCE_TAKEN

TIME = np.arange(0.0, 20.0, 0.01)
SPEED = 4.0 * math.pi  # rad/s
CLEARANCE = 0.08
BEGIN = 8.0


def backward_whirl(time=TIME, frequency=-5.0):
    """A centre line that rests on the axis and from 8 s on whirls, growing to 60 mm within a second."""
    radius = 0.06 * np.clip(time - BEGIN, 0.0, 1.0)
    angle = 2.0 * math.pi * frequency * time
    noise = np.random.default_rng(1).normal(scale=2e-5, size=(2, time.size))
    return radius * np.cos(angle) + noise[0], radius * np.sin(angle) + noise[1]


def test_onset_frequency_and_sense_are_found():
    whirl = dt.analyze(TIME, *backward_whirl(), SPEED, clearance=CLEARANCE, radius="10 mm")
    assert whirl.onset_s == pytest.approx(BEGIN + 0.05 * CLEARANCE / 0.06, abs=0.05)
    assert whirl.frequency_hz == pytest.approx(-5.0, rel=1e-3)
    assert whirl.precession[-1] == pytest.approx(-5.0, rel=1e-3)
    assert whirl.ratio[-1] == pytest.approx(-2.5, rel=1e-3)
    assert whirl.motion[-1]["state"] == "backward whirl"
    assert whirl.motion[-1]["end_s"] == TIME[-1]
    assert whirl.notes == whirl.summary.notes


def test_rotation_is_one_value_a_text_or_an_array():
    x, y = backward_whirl()
    same = [dt.analyze(TIME, x, y, given, clearance="80 mm") for given in (SPEED, "120 rpm", np.full(TIME.size, SPEED))]
    assert {whirl.onset_s for whirl in same} == {same[0].onset_s}
    assert same[0].onset_s is not None


def test_columns_are_marks():
    x, y = backward_whirl()
    still = np.zeros_like(x)
    whirl = dt.analyze(
        TIME, np.column_stack((still, x)), np.column_stack((still, y)), SPEED, clearance=CLEARANCE, names=("top", "mid")
    )
    assert whirl.marks == ("top", "mid")
    assert whirl.onset.mark == "mid"
    assert whirl.orbit_radius.shape == (TIME.size, 2)
    assert whirl.summary.mark_onset_s["top"] is None


def test_without_a_clearance_the_largest_radius_stands_in_and_a_note_says_so():
    whirl = dt.analyze(TIME, *backward_whirl(), SPEED)
    assert whirl.onset_s == pytest.approx(BEGIN, abs=0.1)
    assert CLEARANCE_TAKEN in whirl.notes


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"time": TIME[::-1]}, "each above the one before, found 19.98 at index 1"),
        ({"time": TIME[:1]}, "expected at least two times"),
        ({"x": np.zeros(7)}, r"x: expected shape \(2000,\) or \(2000, m\)"),
        ({"y": np.zeros((2000, 2))}, "x, y: expected arrays of one shape"),
        ({"x": ["a"] * 2000}, "x: expected numbers"),
        ({"x": np.full(2000, np.nan)}, "expected positions"),
        ({"rotation": np.zeros(7)}, r"rotation: expected one speed \[rad/s\] or shape \(2000,\)"),
        ({"rotation": "3 m"}, "rotation: expected a speed of rotation"),
        ({"clearance": -1.0}, "expected a clearance above 0 m"),
        ({"clearance": "2 kg"}, "clearance: expected a length"),
        ({"names": ("a", "b")}, "names: expected 1"),
        ({"on": "rim"}, "expected on = 'wall' or 'centre'"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_in_words(change, words):
    x, y = backward_whirl()
    given = {"time": TIME, "x": x, "y": y, "rotation": SPEED, "clearance": CLEARANCE} | change
    with pytest.raises(dt.DrillTwinError, match=words):
        dt.analyze(**given)
