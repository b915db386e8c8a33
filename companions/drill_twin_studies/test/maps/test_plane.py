# SPDX-License-Identifier: Apache-2.0
"""Search for boundaries on a lattice, and what is read off it, with boundaries known in closed form."""

import math

import numpy as np
import pytest

from drill_twin.core.errors import ArgumentError
from drill_twin_studies.maps.plane import UNKNOWN, Plane, Span, boundary, filled, wanted

STEPS = 128
PLANE = Plane(Span(0.0, 1.0), Span(0.0, 1.0), STEPS)


def whirls(node):
    """A quarter disc of calm, as an onset that falls with speed."""
    return int(math.hypot(*node) > 0.6 * STEPS)


def search(label, *, coarse=16, finest=1, hint=None, first=None):
    labels = PLANE.labels() if first is None else first.copy()
    while nodes := wanted(labels, coarse, finest, hint, 4):
        for node in nodes:
            labels[node] = label(node)
    return labels


def test_a_boundary_is_found_to_a_step_with_few_runs():
    labels = search(whirls)
    exact = np.array([[whirls((i, j)) for j in range(STEPS + 1)] for i in range(STEPS + 1)])
    wrong = np.argwhere(filled(labels) != exact)
    assert all(abs(math.hypot(i, j) - 0.6 * STEPS) <= 1.0 for i, j in wrong.tolist())
    assert (labels != UNKNOWN).sum() < 0.05 * labels.size
    points = np.array(list(boundary(filled(labels) == 1))).reshape(-1, 2)
    assert np.abs(np.hypot(*points.T) - 0.6 * STEPS).max() <= 1.0


def test_a_search_that_was_broken_off_ends_with_the_same_runs():
    whole = search(whirls)
    known = np.argwhere(whole != UNKNOWN)
    first = PLANE.labels()
    for i, j in np.random.default_rng(3).permutation(known)[: len(known) // 2].tolist():
        first[i, j] = whole[i, j]
    assert np.array_equal(search(whirls, first=first), whole)


def test_a_hint_leads_to_an_island_between_the_first_runs():
    def island(node):
        return int(math.hypot(node[0] - 72, node[1] - 88) < 7.0)

    hint = np.array([[island((i + 1, j)) for j in range(STEPS + 1)] for i in range(STEPS + 1)], np.int8)
    assert not (search(island, coarse=16) == 1).any()
    found = filled(search(island, coarse=16, hint=hint))
    assert (found == 1).sum() == sum(island((i, j)) for i in range(STEPS + 1) for j in range(STEPS + 1))


def test_boundary_segments_close_around_a_flagged_node():
    flags = np.zeros((5, 5), bool)
    flags[2, 2] = True
    ends = [tuple(point) for segment in boundary(flags) for point in segment]
    assert len(ends) == 8
    assert all(ends.count(point) == 2 for point in ends)


@pytest.mark.parametrize(
    ("weight", "steps", "said"),
    [
        (Span(3.0, 3.0), 16, "LOW below HIGH, found 3 to 3"),
        (Span(5.0, 1.0), 16, "LOW below HIGH, found 5 to 1"),
        (Span(0.0, math.nan), 16, "LOW below HIGH"),
        (Span(0.0, 1.0), 100, "a power of 2 from 8 to 1024, found 100"),
    ],
)
def test_absurd_ranges_are_refused(weight, steps, said):
    with pytest.raises(ArgumentError, match=said):
        Plane(weight, Span(0.0, 1.0), steps).checked()
