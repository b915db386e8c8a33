# SPDX-License-Identifier: Apache-2.0
"""Runs of a twin: the loop that a session without ROS and the simulator node share, and the session."""

from drill_twin.runs.compilation import compile_kernel
from drill_twin.runs.loop import RunLoop
from drill_twin.runs.session import Outcome, Progress, Session
from drill_twin.runs.session_run import SessionRun

__all__ = ["Outcome", "Progress", "RunLoop", "Session", "SessionRun", "compile_kernel"]
