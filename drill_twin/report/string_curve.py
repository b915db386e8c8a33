# SPDX-License-Identifier: Apache-2.0
"""Curve of the string between its nodes, and the hole, for drawing.

The curve is cubic like the elements, not a polygon. The hole is as it is drilled, for the 3-D views of the report and
of the live page.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.discretisation.discretise import axis_at, survey_of
from drill_twin.io.messages.drawing.geometry import default_exaggeration
from drill_twin.physics.model.strain import transverse_axes
from drill_twin.physics.model.survey import top_frame
from drill_twin.physics.model.wellbore import to_hole_coordinates
from drill_twin.scene import Scene

FINEST = 100
"""Points of a drawn curve; a mesh with more nodes is drawn without further points."""
VERTICAL = 1e-3
"""Sine of the inclination below which a hole has no low side."""


def along_hole(scene: Scene, curves: Array) -> Array:
    """Curves in coordinates of the wellbore: x and y off its axis, z = minus the measured depth.

    Args:
        scene: The scene; curves of a straight hole are returned unchanged.
        curves: Positions in the frame `hole` from the bit up [m], shape (T, k, 3).
    """
    line = survey_of(scene.hole)
    if line is None or not curves.size:
        return curves
    up = arc_of(curves[0])
    return to_hole_coordinates(line.at(scene.length * (1.0 - up / up[-1])), curves)


def arc_of(points: Array) -> Array:
    """Length of a curve up to each of its points [m], shape (k,)."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def low_side(scene: Scene, depth: Array) -> tuple[ComplexArray, Array]:
    """Direction of gravity across the hole at measured depths [m], and the angle of the hole from the vertical [rad].

    The direction is x + i y, of the length sin(inclination).
    """
    top, axis = scene.hole.top_inclination, axis_at(scene, np.clip(depth, 0.0, None))
    if axis is None:
        return np.full(depth.shape, np.sin(top), complex), np.full(depth.shape, top)
    down, (x, y) = np.array([np.sin(top), 0.0, -np.cos(top)]), transverse_axes(axis.tangent)
    low = x @ down + 1j * (y @ down)
    return low, np.arctan2(np.abs(low), -axis.tangent @ down)


def smooth(position: Array, tangent: Array) -> Array:
    """Cubic Hermite curve through nodes with their tangents.

    Args:
        position: Node positions [m], shape (T, n + 1, 3).
        tangent: Unit tangents, shape (T, n + 1, 3).

    Returns:
        Points on the curve [m], the nodes among them, shape (T, k, 3).
    """
    elements = position.shape[1] - 1
    pieces = max(1, FINEST // max(elements, 1))
    return position if pieces == 1 or elements < 1 else refined(position, tangent, np.arange(pieces) / pieces)


def refined(position: Array, tangent: Array, fractions: Array) -> Array:
    """Points of the same curve at given fractions of each element.

    Args:
        position: Node positions [m], shape (T, n + 1, 3).
        tangent: Unit tangents, shape (T, n + 1, 3).
        fractions: From 0, with it, up to 1, without it, shape (p,).

    Returns:
        Points [m], and the last node, shape (T, n p + 1, 3).
    """
    u = fractions[:, None]
    begin, end = position[:, :-1, None], position[:, 1:, None]
    chord = np.linalg.norm(end - begin, axis=-1, keepdims=True)
    leave, arrive = chord * tangent[:, :-1, None], chord * tangent[:, 1:, None]
    curve = (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * begin
        + u * (1.0 - u) ** 2 * leave
        + u**2 * (3.0 - 2.0 * u) * end
        + u**2 * (u - 1.0) * arrive
    )
    return np.concatenate((curve.reshape(position.shape[0], -1, 3), position[:, -1:]), axis=1)


FLAT = 600.0
"""Length of a string above which its views are flat, across the hole over depth [m]: in three dimensions its widths
would have to be drawn hundreds of times too wide."""
ASSEMBLY = 300.0
"""Distance from the bit within which marks decide what a flat view shows first [m]."""


def assembly_top(scene: Scene) -> float:
    """Measured depth from which a flat view begins [m]: a quarter above the highest mark of the assembly."""
    near = [mark.distance_from_bit for mark in scene.string.marks if mark.distance_from_bit <= ASSEMBLY]
    return max(scene.length - max(1.25 * max(near, default=ASSEMBLY), 10.0), 0.0)


def widest(scene: Scene) -> float:
    """Largest radius of the hole [m]."""
    return max(scene.hole.radius, *(interval.radius for interval in scene.hole.intervals), 0.0)


def deviated(scene: Scene) -> bool:
    """True for a curved or inclined hole, which is drawn as it is drilled; a vertical hole is drawn in mm and m."""
    return bool(scene.hole.survey) or scene.hole.top_inclination != 0.0


def well_geometry(scene: Scene, stations: int = 101) -> dict[str, Any]:
    """Centre and transverse axes of the hole, and its radius, by measured depth, with a depth just above each step.

    A deviated hole is in north, east and depth [m], with radii `factor` times too wide. A vertical hole is in
    the frame `hole`, with x and y in mm, a factor of 1000.
    """
    edges = [at for interval in scene.hole.intervals for at in (interval.top, interval.bottom) if at < scene.length]
    edge = np.array(edges)
    at = (np.linspace(0.0, scene.length, stations), edge, edge[edge > 0.0] - 1e-6 * scene.length)
    depth = np.unique(np.concatenate(at).round(6))
    if (axis := axis_at(scene, depth)) is None:
        centre = np.stack((0.0 * depth, 0.0 * depth, -depth), axis=1)
        across = tuple(np.tile(row, (depth.size, 1)) for row in np.eye(3)[:2])
    else:
        centre, across = axis.centre, transverse_axes(axis.tangent)
    names, factor = ["x [mm]", "y [mm]", "z [m]"], 1e3
    if deviated(scene):
        hole = scene.hole
        turn = top_frame(hole.top_inclination, hole.survey[0].azimuth if hole.survey else 0.0)
        centre, across = centre @ turn, (across[0] @ turn, across[1] @ turn)
        names = ["north [m]" if hole.survey else "along the section [m]", "east [m]" if hole.survey else "across [m]"]
        names.append("vertical depth [m]")
        factor = default_exaggeration(scene.length, hole.radius)
    return {
        "deviated": deviated(scene),
        "flat": scene.length > FLAT,
        "names": names,
        "factor": factor,
        "depth": depth.tolist(),
        "centre": centre.round(4).tolist(),
        "x": across[0].round(6).tolist(),
        "y": across[1].round(6).tolist(),
        "hole": [scene.hole.radius_at(at) for at in depth.tolist()],
        "rings": sorted({*np.linspace(0.0, scene.length, 6).tolist(), *edges}),
    }
