"""The picture of a map, in its figure and on its page: the margins at the nodes are a set-point's margins there."""

import math

import numpy as np
import pytest

from drill_twin_studies.maps.drawing import boundaries, margins


def test_the_margins_at_the_nodes_are_those_of_the_map(found):
    plane, steps = found.plane, found.plane.steps
    fields = margins(found.calm)
    ranges = (plane.weight.high - plane.weight.low, plane.speed.high - plane.speed.low, 1.0)
    for i, j in np.ndindex(steps + 1, steps + 1):
        if (i + j) % 7 == 0:
            of_node = [float(field[i, j]) / steps * unit for field, unit in zip(fields, ranges, strict=True)]
            assert of_node == pytest.approx([abs(one) for one in found.margin(*plane.command((i, j)))], abs=1e-9)


def test_without_a_boundary_there_is_no_margin():
    assert all(math.isinf(field.min()) for field in margins(np.ones((5, 5), bool)))


def test_the_onset_of_whirl_is_drawn_above_the_other_lines(found):
    assert boundaries(found)[-1].label == "whirl begins from rest"
    assert boundaries(found)[-1].segments == found.lines(found.whirls)
