# SPDX-License-Identifier: Apache-2.0
"""MarkerArray of fixed size for RViz and Foxglove: string, hole, marks and contacts.

A string is about a hundred times as long as its hole is wide. Lateral motion, hole and thickness are therefore
exaggerated by one factor, which the text marker states; a contact at the wall is drawn as a contact.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.io.messages.cdr import Template, sentinel_header, sentinels
from drill_twin.io.messages.drawing.geometry import ExaggeratedGeometry, StringGeometry
from drill_twin.io.messages.stamps import header
from drill_twin.io.messages.topic_row import MARKER_ARRAY
from drill_twin.io.messages.type_store import message

Colour = tuple[float, float, float, float]

_SPHERE, _CYLINDER, _LINE_STRIP, _LINE_LIST, _SPHERE_LIST, _TEXT = 2, 3, 4, 5, 7, 9
_JOINTS = 25  # points and rings along a curved hole

# Palette of Okabe and Ito, for colour-blind readers too.
_STEEL: Colour = (0.35, 0.35, 0.38, 1.0)
_ROCK: Colour = (0.60, 0.50, 0.40, 0.15)
_RING: Colour = (0.60, 0.50, 0.40, 0.60)
_TEXT_COLOUR: Colour = (0.85, 0.85, 0.85, 1.0)
_MARKS: tuple[Colour, ...] = (
    (0.00, 0.45, 0.70, 1.0),
    (0.90, 0.60, 0.00, 1.0),
    (0.00, 0.62, 0.45, 1.0),
    (0.80, 0.47, 0.65, 1.0),
    (0.34, 0.71, 0.91, 1.0),
)
_HALF_FORCE = 10.0
"""Wall force drawn half way between the colours of light and hard contact [N]; chosen, not measured."""
_LIGHT_TOUCH = np.array((0.94, 0.89, 0.26, 1.0), np.float32)
_HARD_TOUCH = np.array((0.84, 0.15, 0.00, 1.0), np.float32)


class MarkerArrayTemplate:
    """visualization_msgs/MarkerArray of one string, drawn with one factor of lateral exaggeration."""

    def __init__(self, geometry: StringGeometry, exaggeration: float) -> None:
        self._drawn_geometry = ExaggeratedGeometry(geometry, exaggeration)
        nodes, marks = len(geometry.node_distances), len(geometry.mark_names)
        frame_id = geometry.frame_id
        self._strings = [part for part, _ in geometry.strings]
        lines = [sentinels(3 * len(range(*part.indices(nodes))), 10 + k) for k, part in enumerate(self._strings)]
        centres = sentinels(3 * marks, 2)
        spots, colours = sentinels(3 * nodes, 3), sentinels(4 * nodes, 4, np.float32)
        thickness = 2.0 * exaggeration * geometry.outer_radius
        mark_size = max(1.5 * thickness, 0.01 * geometry.length)
        markers = [
            *(
                _marker(
                    frame_id, "string", k, _LINE_STRIP, _STEEL, (2.0 * exaggeration * radius, 0.0, 0.0), points=line
                )
                for k, (line, (_, radius)) in enumerate(zip(lines, geometry.strings, strict=True))
            ),
            *_hole(geometry, self._drawn_geometry, exaggeration),
            *(
                _marker(frame_id, "marks", i, _SPHERE, _MARKS[i % len(_MARKS)], (mark_size,) * 3, position=centre)
                for i, centre in enumerate(centres.reshape(marks, 3))
            ),
            _marker(
                frame_id, "contacts", 0, _SPHERE_LIST, _STEEL, (1.2 * thickness,) * 3, points=spots, colours=colours
            ),
            _label(geometry, exaggeration),
        ]
        blocks = (*lines, *centres.reshape(marks, 3), spots, colours)
        self._template = Template(message(MARKER_ARRAY, markers=markers), MARKER_ARRAY, blocks)

    def rows(self, stamps: Sequence[int], positions: Array, mark_positions: Array, wall_force: Array) -> list[bytes]:
        """CDR of the markers of N frames.

        Args:
            stamps: Stamps [ns], N of them.
            positions: Node positions [m], shape (N, n + 1, 3).
            mark_positions: Positions of the marks [m], shape (N, m, 3).
            wall_force: Normal wall force at the nodes [N], shape (N, n + 1). The number of points is
                fixed: nodes without contact are drawn transparent, at the top clamp.
        """
        drawn, marks = self._drawn_geometry.nodes(positions), self._drawn_geometry.marks(mark_positions)
        touching = wall_force > 0.0
        colours = np.zeros((*touching.shape, 4), np.float32)
        if touching.any():
            force = wall_force[touching]
            share = (force / (force + _HALF_FORCE)).astype(np.float32)[:, None]
            colours[touching] = (1.0 - share) * _LIGHT_TOUCH + share * _HARD_TOUCH
        values = [
            *(drawn[:, part] for part in self._strings),
            *(marks[:, k] for k in range(marks.shape[1])),
            drawn * touching[..., None],
            colours,
        ]
        return self._template.rows(stamps, *values)


def _hole(geometry: StringGeometry, drawn_geometry: ExaggeratedGeometry, exaggeration: float) -> list[Any]:
    """Transparent wall (0, and 2 on for further radii), and rings (1): at steps, marks, and along a curved hole."""
    length, steps = geometry.length, geometry.hole_steps
    walls = []
    for k, (top, bottom, radius) in enumerate(steps):
        wide, number = 2.0 * exaggeration * radius, k and k + 1
        if geometry.axis_at is None:
            middle, scale = np.array((0.0, 0.0, -0.5 * (top + bottom))), (wide, wide, bottom - top)
            walls.append(_marker(geometry.frame_id, "hole", number, _CYLINDER, _ROCK, scale, position=middle))
        else:
            joints = max(2, round(_JOINTS * (bottom - top) / length))
            points = geometry.axis_at(np.linspace(top, bottom, joints)).centre.ravel()
            walls.append(
                _marker(geometry.frame_id, "hole", number, _LINE_STRIP, _ROCK, (wide, 0.0, 0.0), points=points)
            )
    along = {0.0, length, *(length - distance for distance in geometry.mark_distances)}
    if geometry.axis_at is not None:
        along |= set(np.linspace(0.0, length, _JOINTS).tolist())
    ring = [
        (depth, radius) for top, bottom, radius in steps for depth in {top, bottom, *along} if top <= depth <= bottom
    ]
    depths, radii = np.array(sorted(set(ring))).T
    rings, thin = drawn_geometry.rings(depths, radii), 0.05 * exaggeration * geometry.hole_radius
    lines = _marker(geometry.frame_id, "hole", 1, _LINE_LIST, _RING, (thin, 0.0, 0.0), points=rings.ravel())
    return [walls[0], lines, *walls[1:]]


def _label(geometry: StringGeometry, exaggeration: float) -> Any:
    """Text that states the factor of lateral exaggeration."""
    size = 0.04 * geometry.length
    return _marker(
        geometry.frame_id,
        "text",
        0,
        _TEXT,
        _TEXT_COLOUR,
        (0.0, 0.0, size),
        position=np.array((0.0, 0.0, 2.0 * size)),
        text=f"lateral motion x {exaggeration:g}",
    )


def _marker(
    frame_id: str,
    space: str,
    number: int,
    kind: int,
    colour: Colour,
    scale: tuple[float, ...],
    *,
    position: Array | None = None,
    points: Array | None = None,
    colours: NDArray[np.float32] | None = None,
    text: str = "",
) -> Any:
    """visualization_msgs/Marker; points and colours are flat arrays of x y z and r g b a."""
    place = np.zeros(3) if position is None else position
    no_time = message("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
    empty = message("sensor_msgs/msg/CompressedImage", header=header(0, ""), format="", data=np.zeros(0, np.uint8))
    return message(
        "visualization_msgs/msg/Marker",
        header=sentinel_header(frame_id),
        ns=space,
        id=number,
        type=kind,
        action=0,
        pose=message(
            "geometry_msgs/msg/Pose",
            position=_point(place),
            orientation=message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        ),
        scale=message("geometry_msgs/msg/Vector3", x=float(scale[0]), y=float(scale[1]), z=float(scale[2])),
        color=_rgba(colour),
        lifetime=no_time,
        frame_locked=False,
        points=[] if points is None else [_point(row) for row in points.reshape(-1, 3)],
        colors=[] if colours is None else [_rgba(row.tolist()) for row in colours.reshape(-1, 4)],
        texture_resource="",
        texture=empty,
        uv_coordinates=[],
        text=text,
        mesh_resource="",
        mesh_file=message("visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, np.uint8)),
        mesh_use_embedded_materials=False,
    )


def _point(xyz: Array) -> Any:
    return message("geometry_msgs/msg/Point", x=float(xyz[0]), y=float(xyz[1]), z=float(xyz[2]))


def _rgba(colour: Sequence[float]) -> Any:
    return message("std_msgs/msg/ColorRGBA", r=colour[0], g=colour[1], b=colour[2], a=colour[3])
