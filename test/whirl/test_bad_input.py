# SPDX-License-Identifier: Apache-2.0
"""Input that cannot be analysed is refused in one line that says what was expected."""

import numpy as np
import pytest
from kinematics import BENCH, MARKS

from drill_twin.core.errors import DrillTwinError
from drill_twin.whirl import AnalysisError, Analyzer, MarkInfo


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clearance": 0.0}, "clearance above 0"),
        ({"clearance": float("nan")}, "clearance above 0"),
        ({"wall_offset": -0.1}, "wall offset"),
        ({"on": "side"}, "'wall' or 'centre'"),
        ({"distance_from_bit": float("inf")}, "distance"),
    ],
)
def test_marks(change, words):
    fields = {"name": "m", "distance_from_bit": 0.5, "on": "wall", "wall_offset": 0.008, "clearance": 0.08}
    with pytest.raises(AnalysisError, match=words) as caught:
        MarkInfo(**(fields | change))
    assert isinstance(caught.value, DrillTwinError)
    assert "\n" not in str(caught.value)


def test_no_marks_or_two_of_one_name():
    with pytest.raises(AnalysisError, match="expected a mark to analyse"):
        Analyzer([])
    with pytest.raises(AnalysisError, match="mark_3 more than once"):
        Analyzer([BENCH, BENCH])


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((0, np.zeros((3, 3)), np.zeros(4), 1.0), r"shape \(4, 3\)"),
        ((0, np.zeros((4, 3)), np.zeros(3), 1.0), r"spin of shape \(4,\)"),
        ((0, np.zeros((4, 3)), np.zeros(4), 1.0, np.zeros(1)), r"wall force of shape \(4,\)"),
        ((0.5, np.zeros((4, 3)), np.zeros(4), 1.0), "whole nanoseconds"),
    ],
)
def test_samples(args, words):
    with pytest.raises(AnalysisError, match=words):
        Analyzer(MARKS).push(*args)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((np.zeros((5, 3, 3)), None), r"positions of shape \(4, 3\) in each of 5 samples .* found \(3, 3\) in 5"),
        ((np.zeros((1, 4, 3)), None), r"positions of shape \(4, 3\) in each of 5 samples .* found \(4, 3\) in 1"),
        ((np.zeros((5, 4, 3)), np.zeros(4)), r"spin of shape \(4,\)"),
    ],
)
def test_blocks(args, words):
    """numpy would repeat one row for all samples."""
    with pytest.raises(AnalysisError, match=words):
        Analyzer(MARKS).push_block(np.arange(5) * 10**7, *args, np.ones(5))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_numbers_that_are_none(value):
    analyzer = Analyzer(MARKS)
    for i in range(100):
        analyzer.push(i * 10**7, np.full((4, 3), value), np.zeros(4), 1.0)
        analyzer.push(i * 10**7, np.zeros((4, 3)), np.full(4, np.nan if np.isfinite(value) else value), 1.0)
    quality = analyzer.quality
    assert quality.accepted == 0
    assert quality.incomplete == 200
    assert "no sample could be analysed" in analyzer.summary().notes


def test_rotation_unknown():
    analyzer = Analyzer(MARKS)
    analyzer.push(0, np.zeros((4, 3)), None, float("nan"))
    assert analyzer.quality.incomplete == 1
