# SPDX-License-Identifier: Apache-2.0
"""Positions of the drawn string, marks and hole, with lateral distances exaggerated about the hole's axis."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.io.messages.topics import FRAME_ID
from drill_twin.physics.model.strain import transverse_axes
from drill_twin.physics.model.wellbore import Axis, from_hole_coordinates, offsets
from drill_twin.scene.blocks.sensors import Sub

_RING_SEGMENTS = 32


Step = tuple[float, float, float]
"""Begin, end and radius of an interval of one radius [m]."""


@dataclass(frozen=True, eq=False)
class StringGeometry:
    """Dimensions of a scene that the markers need."""

    node_distances: Array
    """Distances of the nodes from the bit [m], shape (n + 1,)."""
    mark_names: tuple[str, ...]
    """Names of the marks."""
    mark_distances: tuple[float, ...]
    """Distances of the marks from the bit [m]."""
    length: float
    """Length of the string [m]."""
    outer_radius: float
    """Outer radius of the string [m], the largest where it changes."""
    hole_radius: float
    """Radius of the hole [m]."""
    hole_steps: tuple[Step, ...]
    """Hole by measured depth."""
    string_steps: tuple[Step, ...]
    """String by distance from the bit, blades and joints included."""
    axis_at: Callable[[Array], Axis] | None = None
    """Axis of a curved hole at measured depths [m]; None where it is straight."""
    section_names: tuple[str, ...] = ()
    """Names of the sections whose stress is counted."""
    subs: tuple[Sub, ...] = ()
    """Downhole subs."""
    frame_prefix: str = ""
    """Put before the names of all frames, so that two twins can share a tf tree."""

    @property
    def strings(self) -> list[tuple[slice, float]]:
        """Nodes of each interval of the string, ends included, and its radius [m]."""
        ends = [int(np.abs(self.node_distances - end).argmin()) for _, end, _ in self.string_steps]
        spans = zip([0, *ends[:-1]], ends, self.string_steps, strict=True)
        return [(slice(begin, end + 1), radius) for begin, end, (_, _, radius) in spans if end > begin]

    @property
    def frame_id(self) -> str:
        """Frame of the messages."""
        return self.frame_prefix + FRAME_ID


def default_exaggeration(length: float, hole_radius: float) -> float:
    """Factor, 1, 2 or 5 times a power of ten, with which the hole is drawn about a tenth as wide as long."""
    wanted = max(length / (20.0 * hole_radius), 1.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(min((step * decade for step in (1.0, 2.0, 5.0, 10.0)), key=lambda step: abs(np.log(step / wanted))))


class ExaggeratedGeometry:
    """Drawn positions of one string, with one factor on lateral distances."""

    def __init__(self, geometry: StringGeometry, factor: float) -> None:
        self._geometry, self._factor = geometry, factor
        self._scale = np.array((factor, factor, 1.0))
        self._nodes = self._marks = None
        if geometry.axis_at is not None:
            self._nodes = geometry.axis_at(geometry.length - geometry.node_distances)
            self._marks = geometry.axis_at(geometry.length - np.array(geometry.mark_distances))

    def nodes(self, positions: Array) -> Array:
        """Drawn positions of nodes, from positions in the frame `hole` [m], shape (n + 1, 3)."""
        drawn: Array = positions * self._scale
        if self._nodes is not None:
            drawn = positions + (self._factor - 1.0) * offsets(self._nodes, positions).off
        return drawn

    def marks(self, positions: Array) -> Array:
        """Drawn positions of marks, from x and y off the hole's axis and z along it [m], shape (m, 3)."""
        drawn: Array = positions * self._scale
        return drawn if self._marks is None else from_hole_coordinates(self._marks, drawn)

    def rings(self, depths: Array, radii: Array) -> Array:
        """Line segments of circles at measured depths, with these radii [m]; shape (2 x segments, 3)."""
        angle = np.linspace(0.0, math.tau, _RING_SEGMENTS + 1)
        circle = np.stack((np.cos(angle), np.sin(angle)), axis=1)
        segments = np.stack((circle[:-1], circle[1:]), axis=1).reshape(-1, 2)
        wide = self._factor * radii[:, None, None] * segments
        if self._geometry.axis_at is None:
            return np.concatenate(
                [np.insert(ring, 2, -depth, axis=1) for ring, depth in zip(wide, depths, strict=True)]
            )
        axis = self._geometry.axis_at(depths)
        ex, ey = transverse_axes(axis.tangent)
        round_axis: Array = axis.centre[:, None] + wide[..., 0:1] * ex[:, None] + wide[..., 1:2] * ey[:, None]
        return round_axis.reshape(-1, 3)
