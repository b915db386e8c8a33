# SPDX-License-Identifier: Apache-2.0
"""Scene of a stream: its geometry for the markers of the viewers, its marks and subs for the whirl analysis."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import survey_of
from drill_twin.dynamics.sensors.subs import REAL, subs_by_name, subs_of
from drill_twin.io.messages.drawing.geometry import Step, StringGeometry
from drill_twin.io.messages.topics import imu_topic, sub_of
from drill_twin.scene import Scene
from drill_twin.whirl import AnalysisError, MarkInfo
from drill_twin.whirl.downhole import SubAnalyzer, ToolNoise

MOST_STEPS = 100
"""Most intervals of the string that are drawn one by one."""
INCLINED = 0.002
"""Sine of the inclination, 0.1 degrees, from which a string falls to the low side of the hole."""


def string_geometry(scene: Scene, distances: Array) -> StringGeometry:
    """Geometry of a string that is drawn through nodes at these distances from the bit [m], shape (n + 1,)."""
    line = survey_of(scene.hole)
    marks = scene.string.marks
    return StringGeometry(
        node_distances=distances,
        mark_names=tuple(mark.name for mark in marks),
        mark_distances=tuple(mark.distance_from_bit for mark in marks),
        length=scene.length,
        outer_radius=max(0.5 * section.outer_diameter for section in scene.string.sections),
        hole_radius=scene.hole.radius,
        hole_steps=hole_steps(scene),
        string_steps=string_steps(scene),
        axis_at=None if line is None else line.at,
        subs=tuple(subs_of(scene)),
        section_names=() if scene.effects.fatigue is None else tuple(s.name for s in scene.effects.fatigue.sections),
    )


def hole_steps(scene: Scene) -> tuple[Step, ...]:
    """Measured depths of top and bottom, and radius, of the intervals of the hole [m], from the top down."""
    edges = {at for interval in scene.hole.intervals for at in (interval.top, interval.bottom)}
    depths = [0.0, *sorted(at for at in edges if 0.0 < at < scene.length), scene.length]
    middle = (0.5 * (top + bottom) for top, bottom in pairwise(depths))
    return _merged([(*span, scene.hole.radius_at(at)) for span, at in zip(pairwise(depths), middle, strict=True)])


def string_steps(scene: Scene) -> tuple[Step, ...]:
    """Distances from the bit and radius of the string's intervals [m], blades included, from the bit up.

    Tool joints too, unless there are very many: then a section has the radius of its joints.
    """
    sections = scene.string.sections
    pieces = scene.string.pieces
    rows = [(piece.length, piece.contact_diameter) for piece in pieces]
    if len(rows) > MOST_STEPS:
        rows = [(s.length, max(s.contact_diameter, s.joints.diameter if s.joints else 0.0)) for s in sections]
    ends = np.cumsum([0.0, *(length for length, _ in rows)]).tolist()
    return _merged([(*span, 0.5 * wide) for span, (_, wide) in zip(pairwise(ends), rows, strict=True)])


def _merged(steps: list[Step]) -> tuple[Step, ...]:
    """Intervals, neighbours of one radius put together."""
    found: list[Step] = []
    for begin, end, radius in steps:
        same = bool(found) and found[-1][2] == radius
        found.append((found.pop()[0] if same else begin, end, radius))
    return tuple(found)


def mark_infos(scene: Scene) -> list[MarkInfo]:
    """Marks of a scene for the whirl analysis."""
    return [_info(scene, mark.name, mark.distance_from_bit, mark.on) for mark in scene.string.marks]


def _info(scene: Scene, name: str, at: float, on: Literal["centre", "wall"]) -> MarkInfo:
    inclined = math.sin(scene.inclination_at(at)) > INCLINED
    return MarkInfo(name, at, on, scene.outer_radius_at(at), scene.clearance_at(at), inclined)


def select_marks(marks: Sequence[MarkInfo], names: Sequence[str]) -> list[MarkInfo]:
    """Select the marks of these names, in the order of the string; all if there are no names.

    Raises:
        AnalysisError: A name is no mark's name.
    """
    known = [mark.name for mark in marks]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise AnalysisError(f"expected marks of {', '.join(known)}, found {', '.join(unknown)}; name some of these")
    return [mark for mark in marks if mark.name in names or not names]


def readings_topic(sub: str) -> str:
    """Topic of the readings of a sub, `NAME`, or `measured/NAME` for a sub of a real rig.

    Raises:
        AnalysisError: The name is no name of a sub.
    """
    name = sub.removeprefix(REAL)
    topic = f"/{REAL}{imu_topic(name)[1:]}" if sub.startswith(REAL) else imu_topic(name)
    if sub_of(topic) != name:
        raise AnalysisError(f"expected the name of a sub, as near_bit or {REAL}near_bit, found {sub!r}")
    return topic


def sub_analyzer(scene: Scene, sub: str) -> SubAnalyzer:
    """Analysis of the readings of a sub.

    Args:
        scene: The scene that lists the sub.
        sub: Name of the sub, `measured/NAME` for a sub of a real rig.

    Raises:
        AnalysisError: The scene does not list the sub.
    """
    listed = subs_by_name(scene)
    found = listed.get(sub.removeprefix(REAL))
    if found is None:
        raise AnalysisError(f"expected a sub that the scene lists, one of {', '.join(listed) or 'none'}, found {sub!r}")
    noise = ToolNoise(found.accelerometer.noise, found.gyroscope.noise)
    section = _info(scene, found.name, found.distance_from_bit, "centre")
    return SubAnalyzer(section, found.radius, noise)
