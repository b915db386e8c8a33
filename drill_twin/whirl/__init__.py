# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis: onset, precession, motion states. Independent of ROS and files.

`Analyzer` works on a stream of samples of the marks, `two_sided_spectrum` on a whole record.
"""

from drill_twin.whirl.analyzer import Analyzer, BitOnlyAnalyzer
from drill_twin.whirl.criteria import BitMotion, MotionCode, MotionState, StickSlipCode
from drill_twin.whirl.findings import Findings, MotionPeriod, Onset, Quality, StickSlipPeriod, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.spectrum import Peak, Spectrum, spectrum_over_time, two_sided_spectrum

__all__ = [
    "AnalysisError", "Analyzer", "BitMotion", "BitOnlyAnalyzer", "Findings", "MarkInfo", "MotionCode",
    "MotionPeriod", "MotionState", "Onset", "Peak", "Quality", "Spectrum", "StickSlip", "StickSlipCode",
    "StickSlipPeriod", "Summary", "spectrum_over_time", "two_sided_spectrum",
]  # fmt: skip
