# SPDX-License-Identifier: Apache-2.0
"""Whirl found on the stream: onset, precession, motion states. Knows neither ROS nor files.

`Analyzer` takes one sample of the marks at a time; `two_sided_spectrum` looks at a whole record at once.
"""

from drill_twin.whirl.analyzer import Analyzer
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.findings import Findings, MotionPeriod, Onset, Quality, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo
from drill_twin.whirl.spectrum import Peak, Spectrum, centre_line, two_sided_spectrum

__all__ = [
    "AnalysisError",
    "Analyzer",
    "Criteria",
    "Findings",
    "MarkInfo",
    "MotionPeriod",
    "MotionState",
    "Onset",
    "Peak",
    "Quality",
    "Spectrum",
    "Summary",
    "centre_line",
    "two_sided_spectrum",
]
