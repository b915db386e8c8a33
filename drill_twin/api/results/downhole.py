# SPDX-License-Identifier: Apache-2.0
"""Whirl of a recorded run from the readings of one downhole sub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drill_twin.core.errors import ArgumentError
from drill_twin.io.downhole import sub_analyzer
from drill_twin.whirl import Summary

if TYPE_CHECKING:
    from drill_twin.api.results.result import Result


def whirl_from_sub(result: Result, name: str) -> Summary:
    """Findings of the whirl analysis from the readings of a sub alone (`drill_twin.whirl.downhole`).

    Args:
        result: The run; its scene lists the sub.
        name: Name of the sub, `measured/NAME` for that of a real rig.

    Raises:
        ArgumentError: The bag has no readings of it.
        AnalysisError: The scene does not list it, or the readings hold too few revolutions without a gap.
    """
    read = {key: sub for key, sub in result.measured.subs.items() if len(sub.imu)}
    if name not in read:
        raise ArgumentError(f"expected a sub with readings, one of {', '.join(read) or 'none'}, found {name!r}")
    analyzer = sub_analyzer(result.scene, name)
    for stamp, values in zip(read[name].imu.stamp.tolist(), read[name].imu.values, strict=True):
        analyzer.push(stamp, values)
    return analyzer.checked_summary()
