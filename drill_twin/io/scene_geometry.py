# SPDX-License-Identifier: Apache-2.0
"""Geometry of a scene's string: for the markers of the viewers and for the whirl analysis."""

from __future__ import annotations

import math

from drill_twin.discretisation.discretise import survey_of
from drill_twin.io.messages.geometry import StringGeometry
from drill_twin.scene import Scene
from drill_twin.twin.twin import Twin
from drill_twin.whirl import MarkInfo

INCLINED = 0.002
"""Sine of the inclination, 0.1 degrees, from which a string falls to the low side of the hole."""


def string_geometry(twin: Twin) -> StringGeometry:
    """Geometry of the string for the markers in RViz and Foxglove."""
    scene = twin.scene
    line = survey_of(scene)
    marks = scene.string.marks
    return StringGeometry(
        node_count=twin.elements + 1,
        mark_names=tuple(mark.name for mark in marks),
        mark_distances=tuple(mark.distance_from_bit for mark in marks),
        length=scene.length,
        outer_radius=max(0.5 * section.outer_diameter for section in scene.string.sections),
        hole_radius=scene.hole.radius,
        node_distances=twin.rod.arc,
        axis_at=None if line is None else line.at,
    )


def mark_infos(scene: Scene) -> list[MarkInfo]:
    """Marks of a scene for the whirl analysis."""
    return [
        MarkInfo(
            name=mark.name,
            distance_from_bit=mark.distance_from_bit,
            on=mark.on,
            wall_offset=scene.outer_radius_at(mark.distance_from_bit),
            clearance=scene.clearance_at(mark.distance_from_bit),
            inclined=math.sin(scene.inclination_at(mark.distance_from_bit)) > INCLINED,
        )
        for mark in scene.string.marks
    ]
