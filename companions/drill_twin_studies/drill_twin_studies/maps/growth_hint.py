# SPDX-License-Identifier: Apache-2.0
"""Expectation of whirl over the plane, from the growth rates of the linear string and the runs so far.

A whirl that grows slowly begins after the end of a run, and friction starts others that no growth rate knows. So the
growth rate at which whirl begins is taken from the runs, not to be zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError
from drill_twin.scene import Scene
from drill_twin_studies.maps.plane import UNKNOWN, Labels, Plane, on_lattice

GROWTH_POINTS = 33
"""Points of the map of growth rates along each range."""


class Growth(NamedTuple):
    """Largest growth rates on even grids over the plane."""

    lateral: Array
    """Of a lateral mode [1/s]: onset of whirl."""
    torsional: Array | None
    """Of a motion about or along the axis [1/s]: onset of stick-slip; None in the lateral form."""


def growth_of(scene: Scene, plane: Plane) -> Growth | None:
    """Largest growth rates over the plane; None where the string has no such map."""
    from drill_twin.dynamics.rotordynamics.campbell import growth_map
    from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion

    weights, speeds = (np.linspace(span.low, span.high, GROWTH_POINTS) for span in (plane.weight, plane.speed))
    try:
        found = growth_map(EquationsOfMotion(scene), weights, speeds)
    except DrillTwinError:  # a hole that is not vertical, an effect that depends on time, no balance
        return None
    return Growth(found.lateral, found.torsional)


def expected(growth: Array, labels: Labels) -> Labels | None:
    """Labels that the growth rates let expect: whirl above the rate that parts the known labels with the fewest errors.

    Args:
        growth: Growth rates on an even grid [1/s].
        labels: What is known of whirl; with one label only the rate is zero.

    Returns:
        Expected label of each node; None where the growth rates explain less than half of the rarer label.
    """
    values, known = on_lattice(growth, labels.shape[0] - 1), labels != UNKNOWN
    order = np.argsort(values[known], kind="stable")
    rates, whirls = values[known][order], labels[known][order] == 1
    rarer = min(whirls.sum(), (~whirls).sum())
    if rarer == 0:
        return np.asarray(values > 0.0, np.int8)
    below, above = np.cumsum(whirls)[:-1], np.cumsum(~whirls[::-1])[-2::-1]
    errors = np.where(np.diff(rates) > 0.0, below + above, whirls.size)
    place = int(np.argmin(errors, axis=0)) if errors.size else 0
    if not errors.size or 2 * errors[place] >= rarer:
        return None
    return np.asarray(values > 0.5 * (rates[place] + rates[place + 1]), np.int8)
