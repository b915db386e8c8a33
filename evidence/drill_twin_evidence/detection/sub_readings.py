# SPDX-License-Identifier: Apache-2.0
"""Readings of a sub with errors, through its analysis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drill_twin.whirl.downhole import SubAnalyzer, ToolNoise
from drill_twin_evidence.detection.runs import SENSOR_RADIUS, Run

NOISE = ToolNoise(0.005, 0.001)
"""Noise of the sub: accelerometers [m/s^2], gyroscopes [rad/s]."""
BIAS = ToolNoise(0.05, 0.005)
"""Standard deviation of the bias on each axis."""
MARK = 2
"""Mark at whose section the sub is: the middle of the string."""


def analyser_of(run: Run, seed: int, *, mark: int = MARK) -> SubAnalyzer:
    """Analysis of all readings of a sub, with noise and bias drawn from a seed."""
    if run.readings is None:
        raise ValueError("expected a run with the readings of subs")
    draw = np.random.default_rng([seed, 12])
    readings = run.readings[:, mark] + np.repeat(NOISE, 3) * draw.normal(size=(run.time.size, 6))
    readings += np.repeat(BIAS, 3) * draw.normal(size=6)
    middle = run.time - 0.5 * (run.time[1] - run.time[0])
    analyzer = SubAnalyzer(replace(run.marks[mark], on="centre"), SENSOR_RADIUS, NOISE)
    for stamp, values in zip(np.round(middle * 1e9).astype(np.int64).tolist(), readings, strict=True):
        analyzer.push(stamp, values)
    return analyzer
