# SPDX-License-Identifier: Apache-2.0
"""Whirl found on the stream: onset, precession, motion states. Knows neither ROS nor files.

`Analyzer` takes one sample of the marks at a time; `two_sided_spectrum` looks at a whole record at once.
"""

from drill_twin.whirl.analyzer import Analyzer
from drill_twin.whirl.bit_only_analyzer import BitOnlyAnalyzer
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.findings import Findings, MotionPeriod, Onset, Quality, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo
from drill_twin.whirl.motion.stick_slip import BitMotion, StickSlip, StickSlipPeriod
from drill_twin.whirl.spectrum import Peak, Spectrum, centre_line, spectrum_over_time, two_sided_spectrum

__all__ = [
    "AnalysisError",
    "Analyzer",
    "BitMotion",
    "BitOnlyAnalyzer",
    "Criteria",
    "Findings",
    "MarkInfo",
    "MotionPeriod",
    "MotionState",
    "Onset",
    "Peak",
    "Quality",
    "Spectrum",
    "StickSlip",
    "StickSlipPeriod",
    "Summary",
    "centre_line",
    "spectrum_over_time",
    "two_sided_spectrum",
]
