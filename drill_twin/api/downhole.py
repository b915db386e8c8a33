# SPDX-License-Identifier: Apache-2.0
"""Whirl of a recorded run from the readings of one downhole sub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drill_twin.errors import ArgumentError
from drill_twin.io.scene_geometry import sub_info
from drill_twin.whirl import Summary
from drill_twin.whirl.downhole import ToolNoise, analyse_sub

if TYPE_CHECKING:
    from drill_twin.api.result import Result


def whirl_from_sub(result: Result, name: str) -> Summary:
    """Findings of the whirl analysis from the readings of a sub alone (`drill_twin.whirl.downhole`).

    Args:
        result: The run; its scene lists the sub.
        name: Name of the sub, `measured/NAME` for that of a real rig.

    Raises:
        ArgumentError: The bag has no readings of it, or the scene does not list it.
        AnalysisError: The readings are not evenly spaced, do not turn, or are too few.
    """
    read = {key: sub for key, sub in result.measured.subs.items() if len(sub.imu)}
    if name not in read:
        raise ArgumentError(f"expected a sub with readings, one of {', '.join(read) or 'none'}, found {name!r}")
    sensors = result.scene.sensors
    listed = {sub.name: sub for sub in (() if sensors is None else sensors.subs)}
    sub = listed.get(name.removeprefix("measured/"))
    if sub is None:
        raise ArgumentError(
            f"expected a sub that the scene lists, one of {', '.join(listed) or 'none'}, found {name!r}"
        )
    noise = ToolNoise(sub.accelerometer.noise, sub.gyroscope.noise)
    imu = read[name].imu
    return analyse_sub(imu.stamp, imu.values, sub_info(result.scene, sub), sub.radius, noise)
