# SPDX-License-Identifier: Apache-2.0
"""Report of a bag: summary as JSON, figures, and a page with both.

>>> files = build_report("out/run/bag_0", "out/run")
>>> summarise("out/run/bag_0")["onset_s"]
"""

from drill_twin.report.build import ReportFiles, build_report
from drill_twin.report.recording import Recording, read_recording
from drill_twin.report.summary import summarise

__all__ = ["Recording", "ReportFiles", "build_report", "read_recording", "summarise"]
