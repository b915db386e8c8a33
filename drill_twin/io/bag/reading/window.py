# SPDX-License-Identifier: Apache-2.0
"""Search for the blocks of a file with header stamps between two times."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence

from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import TOPICS

WITH_HEADER = frozenset({"sensor_msgs/msg/JointState", "geometry_msgs/msg/PoseArray"})
"""Types of the contract that begin with a header, by whose stamps a window is searched."""
LATCHED = tuple(name for name, topic in TOPICS.items() if topic.latched)
"""Ends of the names of topics whose messages are read wherever they are."""
MOST_LATCHED = 50
"""Messages, or chunks with them, that are read of such a topic."""
_MARGIN = 1.0  # s by which topics may come after one another


def blocks_between(total: int, begin: float, end: float, stamps_at: Callable[[int], Sequence[int]]) -> range:
    """Numbers of the blocks with header stamps between two times, and of their neighbours.

    Recorded and header time may differ by any amount, but both rise, so that a bisection finds the ends.

    Args:
        total: Number of blocks.
        begin: Earliest stamp [s].
        end: Latest stamp [s].
        stamps_at: Header stamps [ns] in the block of a number.
    """

    def time_from(k: int) -> float:
        """Median header stamp [s] of the first block from a number on that has any."""
        stamps = next((found for number in range(k, total) if (found := stamps_at(number))), None)
        return math.inf if stamps is None else seconds(sorted(stamps)[len(stamps) // 2])

    first = bisect_left(range(total), begin - _MARGIN, key=time_from) if begin > -math.inf else 0
    last = bisect_right(range(total), end + _MARGIN, lo=first, key=time_from) if end < math.inf else total
    return range(max(first - 1, 0), min(last + 1, total))
