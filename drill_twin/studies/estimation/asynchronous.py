# SPDX-License-Identifier: Apache-2.0
"""Radius of the asynchronous motion in a window: what is whirl, and neither offset nor runout."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame_record import FrameSeries

_LEAST_TURN = 1.0
"""Revolutions that a window must have, to tell offset, synchronous part and the rest apart."""


def asynchronous_radius(rows: FrameSeries) -> Array:
    """Rms radius of z - c - S exp(i spin) at each mark over recorded frames [m], shape (m,); 0 within a revolution.

    Offset c and synchronous part S are a least-squares fit over the window; the analyzer's has a fading memory
    (`drill_twin.whirl.orbit.runout_separation`).
    """
    found = np.zeros(rows.spin.shape[1])
    for mark in range(found.size):
        spin = rows.spin[:, mark]
        if abs(spin[-1] - spin[0]) < 2.0 * np.pi * _LEAST_TURN:
            continue
        motion = rows.centre[:, mark, 0] + 1j * rows.centre[:, mark, 1]
        parts = np.column_stack((np.ones(spin.size), np.exp(1j * spin)))
        fitted = parts @ np.linalg.lstsq(parts, motion, rcond=None)[0]
        found[mark] = np.sqrt(np.mean(np.abs(motion - fitted) ** 2))
    return found
