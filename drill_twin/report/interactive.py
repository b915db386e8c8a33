# SPDX-License-Identifier: Apache-2.0
"""Data of the interactive view: the well, and shapes of the string and paths of the marks as small integers in base64.

Shapes and paths are in the frame of the hole at their depth; `view.js` puts them into the well as it is drilled.
"""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import axis_at, contact_radius
from drill_twin.io.messages.geometry import default_exaggeration
from drill_twin.model.survey import top_frame
from drill_twin.model.wellbore_coordinates import transverse_axes
from drill_twin.report.figures.style import MARK_COLOURS
from drill_twin.report.recording import Recording
from drill_twin.scene import Scene

_POINTS, _SHAPE_POINTS = 160, 36_000
"""Most points of a shape, and of all shapes together."""
_SAMPLES = 30_000
"""Most samples of a mark's path."""
_FULL = 16_000
"""Integer for the largest radius of the hole, or for the string's length."""
_STATIONS = 101
"""Depths at which the hole is given."""


def view_data(recording: Recording) -> str:
    """JSON for `view.js`; coordinates are int16 in base64, as shares of the hole's radius and of the length."""
    radius, length = widest(recording.scene), recording.scene.length
    shapes = recording.shapes()
    shapes = shapes[:, np.unique(np.linspace(0, shapes.shape[1] - 1, _POINTS).round().astype(int))]
    times = np.unique(np.linspace(0, len(shapes) - 1, _SHAPE_POINTS // shapes.shape[1]).round().astype(int))
    shapes = shapes[times]
    every = -(-len(recording.marks) // _SAMPLES)
    centre = recording.centre_lines()[::every]
    height = recording.marks.position[::every, :, 2]
    paths = np.stack((centre.real / radius, centre.imag / radius, height / length), axis=-1)
    onset = recording.summary.onset
    data: dict[str, Any] = {
        "full": _FULL,
        "radius": radius,
        "length": length,
        "well": _well(recording.scene),
        "pipe": contact_radius(recording.scene, np.clip(length + shapes[-1, :, 2], 0.0, length)).tolist(),
        "shapes": {
            "time": _times(recording.poses.time[times]),
            "points": shapes.shape[1],
            "values": _packed(shapes / (radius, radius, length)),
        },
        "paths": {"time": _times(recording.marks.time[::every]), "values": _packed(paths)},
        "marks": [place.name for place in recording.scene.mark_table],
        "walls": [
            recording.scene.hole.radius_at(length - place.distance_from_bit) for place in recording.scene.mark_table
        ],
        "clearance": [place.clearance for place in recording.scene.mark_table],
        "colours": [MARK_COLOURS[mark % len(MARK_COLOURS)] for mark in range(centre.shape[1])],
        "onset": onset.time_s if onset else None,
    }
    return json.dumps(data, allow_nan=False, separators=(",", ":"))


def widest(scene: Scene) -> float:
    """Largest radius of the hole [m]."""
    return max(scene.hole.radius, *(interval.radius for interval in scene.hole.intervals), 0.0)


def deviated(scene: Scene) -> bool:
    """True for a curved or inclined hole, which is drawn as it is drilled; a vertical one is drawn in mm and m."""
    return bool(scene.hole.survey) or scene.hole.top_inclination != 0.0


def _well(scene: Scene) -> dict[str, Any]:
    """Centre and transverse axes of the hole, and its radius, by measured depth, with a depth just above each step.

    A deviated hole is in north, east and depth [m], with radii `factor` times as wide as they are. A vertical one is in
    the frame `hole`, with x and y in mm, a factor of 1000.
    """
    edges = [at for interval in scene.hole.intervals for at in (interval.top, interval.bottom) if at < scene.length]
    edge = np.array(edges)
    at = (np.linspace(0.0, scene.length, _STATIONS), edge, edge[edge > 0.0] - 1e-6 * scene.length)
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


def plotly_packed() -> str:
    """plotly.js, compressed, in base64: a third of its size."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def _times(time: Array) -> list[float]:
    rounded: list[float] = time.round(4).tolist()
    return rounded


def _packed(values: Array) -> str:
    whole = np.clip(np.nan_to_num(values) * _FULL, -32767, 32767).round().astype("<i2")
    return base64.b64encode(whole.tobytes()).decode()
