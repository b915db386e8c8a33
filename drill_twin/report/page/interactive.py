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

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import contact_radius
from drill_twin.report.figures.style import MARK_COLOURS
from drill_twin.report.page.well_geometry import well_geometry, widest
from drill_twin.report.recording import Recording

_POINTS, _SHAPE_POINTS = 160, 36_000
"""Most points of a shape, and of all shapes together."""
_SAMPLES = 30_000
"""Most samples of a mark's path."""
_FULL = 16_000
"""Integer for the largest radius of the hole, or for the string's length."""


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
        "well": well_geometry(recording.scene),
        "pipe": contact_radius(recording.scene, np.clip(length + shapes[-1, :, 2], 0.0, length)).tolist(),
        "shapes": {
            "time": _times(recording.poses.time[times]),
            "points": shapes.shape[1],
            "values": _packed(shapes / (radius, radius, length)),
        },
        "paths": {"time": _times(recording.marks.time[::every]), "values": _packed(paths)},
        "marks": [place.name for place in recording.places],
        "walls": [recording.scene.hole.radius_at(length - place.distance_from_bit) for place in recording.places],
        "clearance": [place.clearance for place in recording.places],
        "colours": [MARK_COLOURS[mark % len(MARK_COLOURS)] for mark in range(centre.shape[1])],
        "onset": onset.time_s if onset else None,
    }
    return json.dumps(data, allow_nan=False, separators=(",", ":"))


def plotly_packed() -> str:
    """plotly.js, compressed, in base64: a third of its size."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def _times(time: Array) -> list[float]:
    rounded: list[float] = time.round(4).tolist()
    return rounded


def _packed(values: Array) -> str:
    whole = np.clip(np.nan_to_num(values) * _FULL, -32767, 32767).round().astype("<i2")
    return base64.b64encode(whole.tobytes()).decode()
