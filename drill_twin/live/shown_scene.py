# SPDX-License-Identifier: Apache-2.0
"""Scene on the live page."""

from __future__ import annotations

import math
from typing import Any

from drill_twin.io.scene_geometry import string_steps
from drill_twin.report.string_curve import well_geometry
from drill_twin.scene import Scene

_STATIONS = 41  # depths at which the hole is drawn, and at each change of its radius


def shown_scene(scene: Scene) -> dict[str, Any]:
    """Well, string, walls and clearances [m] by mark, set-points [N, rev/s] of a scene, as plain types for JSON."""
    marks = scene.string.marks
    return {
        "name": scene.name,
        "units": scene.unit_system.name,
        "length": scene.length,
        "hole": scene.hole.radius,
        "well": well_geometry(scene, _STATIONS),
        "string": string_steps(scene),
        "walls": {mark.name: scene.hole.radius_at(scene.length - mark.distance_from_bit) for mark in marks},
        "clearance": {mark.name: scene.clearance_at(mark.distance_from_bit) for mark in marks},
        "wob": scene.rig.weight_on_bit.value,
        "rps": scene.rig.rotation.value / math.tau,
    }
