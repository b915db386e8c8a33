# SPDX-License-Identifier: Apache-2.0
"""Growth rates lead the search where they part the runs, and are left aside where they do not."""

import numpy as np
import pytest

import drill_twin as dt
from drill_twin_studies.maps.plane import UNKNOWN, Plane, Span
from drill_twin_studies.maps.search import GROWTH_POINTS, expected, growth_of

STEPS = 64
GROWTH = np.add.outer(np.linspace(-1.0, 3.0, GROWTH_POINTS), np.zeros(GROWTH_POINTS))
PLANE = Plane(Span(0.0, 1.0), Span(0.0, 1.0), STEPS)


def known(whirls, every=16):
    """Labels of a coarse lattice."""
    labels = PLANE.labels()
    for i in range(0, STEPS + 1, every):
        for j in range(0, STEPS + 1, every):
            labels[i, j] = whirls(i, j)
    return labels


def test_the_rate_at_which_whirl_begins_is_taken_from_the_runs():
    """Whirl at load shares above 0.55: growth rates above 1.2."""
    found = expected(GROWTH, known(lambda i, _: i > 0.55 * STEPS))
    whirls = found[:, 0] == 1
    assert np.array_equal(found, np.repeat(found[:, :1], STEPS + 1, axis=1))
    assert 0.5 * STEPS < np.argmax(whirls) < 0.75 * STEPS  # between the runs at 32 and 48
    finer = known(lambda i, _: i > 0.55 * STEPS, every=2)
    assert np.argmax(expected(GROWTH, finer)[:, 0] == 1) == pytest.approx(0.55 * STEPS, abs=2)


def test_some_runs_on_the_other_side_change_nothing_many_leave_it_aside():
    few = known(lambda i, j: (i > 32) != (i == j == 0))
    assert expected(GROWTH, few) is not None
    assert expected(GROWTH, known(lambda i, j: (i + j) // 16 % 2)) is None
    assert expected(GROWTH, known(lambda _, j: j > 32)) is None  # whirl that does not depend on growth


def test_without_two_labels_the_rate_is_zero():
    for labels in (PLANE.labels(), known(lambda *_: 1), known(lambda *_: 0)):
        assert np.array_equal(expected(GROWTH, labels)[:, 0] == 1, np.linspace(-1.0, 3.0, STEPS + 1) > 0.0)
    assert (PLANE.labels() == UNKNOWN).all()


@pytest.mark.slow
def test_growth_rates_are_those_of_a_vertical_string_only():
    scene = dt.load_scene("pa6_bench", {"numerics.elements": 8, "numerics.step": "10 ms"})
    plane = Plane(Span(1.0, 40.0), Span(6.0, 40.0), 8)
    assert growth_of(scene, plane).lateral.shape == (GROWTH_POINTS, GROWTH_POINTS)
    inclined = dt.load_scene("pa6_bench", {"numerics.elements": 8, "numerics.step": "10 ms", "hole.inclination": 0.5})
    assert growth_of(inclined, plane) is None
