# SPDX-License-Identifier: Apache-2.0
"""Progress of a measurement in words."""

from __future__ import annotations

import time
from collections.abc import Callable

from drill_twin.studies.accuracy.measure import Report


def in_words(say: Callable[[str], object], every: float = 0.0) -> Report:
    """Progress of a measurement that is told as a text with the share done and the time left.

    Args:
        say: Takes the text.
        every: Least wall-clock time between two texts [s].
    """
    began, said = time.monotonic(), -every

    def report(line: str, share: float) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= every:
            said = now
            left = (now - began) * (1.0 - share) / share if share > 0.0 else 0.0
            say(f"{line}; {share:.0%} done, about {left:.0f} s left")

    return report
