# SPDX-License-Identifier: Apache-2.0
"""Colours and geometry of the picture of a map: the same in its figure, on its page and on the live page."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

from drill_twin.core.arrays import Array, Mask
from drill_twin.studies.maps.operating_map import OperatingMap
from drill_twin.studies.maps.plane import on_lattice

WINDOW_COLOUR = "#00432f"
"""Colour of the edges of the safe windows."""


class Boundary(NamedTuple):
    """Boundary of a field of the map."""

    label: str
    """Words of the legend."""
    segments: list[list[list[float]]]
    """Segments of two points, weight on bit [N] and speed [rad/s]."""
    colour: str
    """Of the line."""
    style: str
    """Of the line: solid, dashed or dotted."""
    width: float
    """Of the line [points]."""


def boundaries(found: OperatingMap) -> list[Boundary]:
    """Lines of a map; the onset of whirl is the last, above the others."""
    lines = []
    if len(found.growth):
        lines.append(Boundary("straight string: growth 0", found.lines(grows(found)), "#0072b2", "dotted", 1.8))
    if found.has_second_boundary:
        ends = found.lines(found.keeps_whirling)
        lines.append(Boundary("an existing whirl dies", ends, "#000000", "dashed", 1.8))
    return [*lines, Boundary("whirl begins from rest", found.lines(found.whirls), "#000000", "solid", 2.2)]


def grows(found: OperatingMap) -> Mask:
    """Nodes at which a mode of the linear string grows."""
    return np.asarray(on_lattice(np.array(found.growth, float), found.plane.steps) > 0.0)


def margins(flags: Mask) -> tuple[Array, Array, Array]:
    """Distances from each node to the boundary of flagged nodes [steps]: along each range, and the shortest.

    That of `OperatingMap.margin` at the nodes, without its sign; infinite where there is no boundary.
    """
    along = [np.apply_along_axis(_to_the_others, axis, flags) for axis in (0, 1)]
    return along[0], along[1], _to_the_others(flags)


def _to_the_others(flags: Mask) -> Array:
    """Distance from each node to the boundary half-way to the nearest node that is flagged otherwise."""
    if flags.all() or not flags.any():
        return np.full(flags.shape, np.inf)
    distance = np.where(flags, distance_transform_edt(flags), distance_transform_edt(~flags))
    return np.asarray(distance - 0.5)
