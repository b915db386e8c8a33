# SPDX-License-Identifier: Apache-2.0
"""The hole as it is drilled, for the 3-D views of the report and of the live page."""

from __future__ import annotations

from typing import Any

import numpy as np

from drill_twin.dynamics.discretisation.discretise import axis_at
from drill_twin.io.messages.drawing.geometry import default_exaggeration
from drill_twin.physics.model.frames import transverse_axes
from drill_twin.physics.model.survey import top_frame
from drill_twin.scene import Scene


def widest(scene: Scene) -> float:
    """Largest radius of the hole [m]."""
    return max(scene.hole.radius, *(interval.radius for interval in scene.hole.intervals), 0.0)


def deviated(scene: Scene) -> bool:
    """True for a curved or inclined hole, which is drawn as it is drilled; a vertical one is drawn in mm and m."""
    return bool(scene.hole.survey) or scene.hole.top_inclination != 0.0


def well_geometry(scene: Scene, stations: int = 101) -> dict[str, Any]:
    """Centre and transverse axes of the hole, and its radius, by measured depth, with a depth just above each step.

    A deviated hole is in north, east and depth [m], with radii `factor` times as wide as they are. A vertical one is in
    the frame `hole`, with x and y in mm, a factor of 1000.
    """
    edges = [at for interval in scene.hole.intervals for at in (interval.top, interval.bottom) if at < scene.length]
    edge = np.array(edges)
    at = (np.linspace(0.0, scene.length, stations), edge, edge[edge > 0.0] - 1e-6 * scene.length)
    depth = np.unique(np.concatenate(at).round(6))
    axis = axis_at(scene, depth)
    if axis is None:
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
        "names": names,
        "factor": factor,
        "depth": depth.tolist(),
        "centre": centre.round(4).tolist(),
        "x": across[0].round(6).tolist(),
        "y": across[1].round(6).tolist(),
        "hole": [scene.hole.radius_at(at) for at in depth.tolist()],
        "rings": sorted({*np.linspace(0.0, scene.length, 6).tolist(), *edges}),
    }
