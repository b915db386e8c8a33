# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis of a downhole sub that a scene lists."""

from __future__ import annotations

from drill_twin.dynamics.sensors.subs import REAL, subs_by_name
from drill_twin.io.messages.topics import imu_topic, sub_of
from drill_twin.io.scene_geometry import sub_info
from drill_twin.scene import Scene
from drill_twin.whirl import AnalysisError
from drill_twin.whirl.downhole import SubAnalyzer, ToolNoise


def readings_topic(sub: str) -> str:
    """Topic of the readings of a sub, `NAME`, or `measured/NAME` for that of a real rig.

    Raises:
        AnalysisError: It is no name of a sub.
    """
    name = sub.removeprefix(REAL)
    topic = f"/{REAL}{imu_topic(name)[1:]}" if sub.startswith(REAL) else imu_topic(name)
    if sub_of(topic) != name:
        raise AnalysisError(f"expected the name of a sub, as near_bit or {REAL}near_bit, found {sub!r}")
    return topic


def sub_analyzer(scene: Scene, sub: str) -> SubAnalyzer:
    """Analysis of the readings of a sub.

    Args:
        scene: The scene that lists it.
        sub: Its name, `measured/NAME` for that of a real rig.

    Raises:
        AnalysisError: The scene does not list it.
    """
    listed = subs_by_name(scene)
    found = listed.get(sub.removeprefix(REAL))
    if found is None:
        raise AnalysisError(f"expected a sub that the scene lists, one of {', '.join(listed) or 'none'}, found {sub!r}")
    noise = ToolNoise(found.accelerometer.noise, found.gyroscope.noise)
    return SubAnalyzer(sub_info(scene, found), found.radius, noise)
