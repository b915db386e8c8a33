# SPDX-License-Identifier: Apache-2.0
"""Length of a frame: whole nanoseconds, as stamps count them, so that a run, its nodes and its bag share every bit."""

_NANOSECONDS = 1_000_000_000


def frame_period_ns(rate: float) -> int:
    """Length of a frame [ns] at a frame rate [Hz], rounded to the nearest."""
    return round(_NANOSECONDS / rate)


def frame_period(rate: float) -> float:
    """As `frame_period_ns`, in seconds."""
    return frame_period_ns(rate) / _NANOSECONDS
