# SPDX-License-Identifier: Apache-2.0
"""Whirl from the readings of one downhole sub."""

from drill_twin.whirl.downhole.analyzer import WAITING, SubAnalyzer
from drill_twin.whirl.downhole.high_pass import ToolNoise

__all__ = ["WAITING", "SubAnalyzer", "ToolNoise"]
