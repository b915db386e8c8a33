# SPDX-License-Identifier: Apache-2.0
"""Ring buffer of the last states, saved on failure, to which compiled code adds without allocation."""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame_kernel import Past

SPAN = 1.0
"""Length of the history [s]."""
MOST_BYTES = 32 * 1024 * 1024
"""Largest size; it limits the number of states of long strings at high frame rates."""


def make_past(nodes: int, frame_rate: float) -> Past:
    """Room for `SPAN` of frames, within `MOST_BYTES`."""
    count = int(np.clip(np.ceil(SPAN * frame_rate), 1, max(MOST_BYTES // (nodes * 14 * 8), 1)))
    return Past(np.full(count, np.nan), np.zeros((count, 2, nodes, 7)), np.zeros(1, np.int64))


def read_past(past: Past) -> tuple[Array, Array, Array]:
    """Times [s], shape (k,), and node rows u and v, shape (k, n + 1, 7) each, oldest first; copies."""
    count, end = past.time.size, int(past.next[0])
    order = np.arange(max(end - count, 0), end) % count
    order = order[past.time[order] > past.time[order[-1]] - SPAN - 1e-9] if order.size else order
    return past.time[order], past.rows[order, 0], past.rows[order, 1]
