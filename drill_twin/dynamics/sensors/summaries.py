# SPDX-License-Identifier: Apache-2.0
"""Summaries that a tool sends up: least, mean and largest speed; rms and peak of the accelerations."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array

SUMMARY = (
    "speed_least", "speed_mean", "speed_largest", "radial_mean", "radial_rms", "radial_peak", "tangential_rms",
    "tangential_peak", "axial_rms", "axial_peak",
)  # fmt: skip
"""Values of a summary: speed of rotation [rad/s]; accelerations [m/s^2], rms and peak about their mean."""


def summary(readings: Array) -> Array:
    """Summary of n readings, shape (..., n, 6), in the order of `SUMMARY`, shape (..., 10)."""
    speed, force = readings[..., 5], readings[..., :3]
    mean = force.mean(-2, keepdims=True)
    rms, peak = np.sqrt(((force - mean) ** 2).mean(-2)), np.abs(force - mean).max(-2)
    columns = [speed.min(-1), speed.mean(-1), speed.max(-1), mean[..., 0, 0]]
    columns += [part[..., axis] for axis in range(3) for part in (rms, peak)]
    return np.stack(columns, -1)
