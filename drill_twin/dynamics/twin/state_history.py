# SPDX-License-Identifier: Apache-2.0
"""Ring buffer of the last states, saved on failure."""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame_kernel import Past

SPAN = 1.0
"""Length of the history [s]."""
MOST_BYTES = 32 * 1024 * 1024
"""Largest size; it limits the number of states of long strings at high frame rates."""


class StateHistory:
    """States at the ends of the last frames, without allocation per frame."""

    def __init__(self, nodes: int, frame_rate: float) -> None:
        """Allocate `SPAN` of frames, within `MOST_BYTES`."""
        count = int(np.clip(np.ceil(SPAN * frame_rate), 1, max(MOST_BYTES // (nodes * 14 * 8), 1)))
        self._time = np.full(count, np.nan)
        self._rows = np.zeros((count, 2, nodes, 7))
        self._next = np.zeros(1, np.int64)

    @property
    def memory(self) -> Past:
        """The arrays, to which compiled code adds states."""
        return Past(self._time, self._rows, self._next)

    def extend(self, time: Array, u: Array, v: Array) -> None:
        """Add states in order: node rows and their velocities, shape (k, n + 1, 7) each, at times [s], shape (k,)."""
        last = slice(max(time.size - self._time.size, 0), None)
        places = (self._next[0] + np.arange(time.size)[last]) % self._time.size
        self._time[places] = time[last]
        self._rows[places, 0], self._rows[places, 1] = u[last], v[last]
        self._next[0] += time.size

    def clear(self) -> None:
        """Remove all states."""
        self._next[0] = 0

    def read(self) -> tuple[Array, Array, Array]:
        """Times [s], shape (k,), and node rows u and v, shape (k, n + 1, 7) each, oldest first; copies."""
        count, end = self._time.size, int(self._next[0])
        order = np.arange(max(end - count, 0), end) % count
        order = order[self._time[order] > self._time[order[-1]] - SPAN - 1e-9] if order.size else order
        return self._time[order], self._rows[order, 0], self._rows[order, 1]
