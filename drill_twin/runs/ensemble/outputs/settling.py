# SPDX-License-Identifier: Apache-2.0
"""Motion still changing at the end of a run: lateral motion neither at rest nor turning with the string, and speeds.

The lateral motion of a mark in each of the last two quarters is z = a + b exp(i psi) + r, with a in space, b in the
string (bow, imbalance, a buckled shape) and psi its spin; a and b by least squares. The rest r is what a whirl begins
as, so its size in the two quarters tells whether a whirl grows long before it reaches the wall.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.outputs.collector import Collector, Request, Variable
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE, stick_slip_index

ROUND_OFF = 1e-8
"""Least rest of the motion that is more than round-off, over the motion itself."""


class Settling(Collector):
    """Size of the rest of the motion in the last two quarters, and stick-slip index in the last two time bases."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._quarter = request.frames // 4
        marks = len(twin.scene.string.marks)
        self._gram = np.zeros((2, marks, 3, 3), complex)  # of 1, exp(i psi) and z
        self._base = max(1, min(self._quarter, math.ceil(TIME_BASE / request.period)))
        self._speed = np.empty((2, 0))  # of bit and top drive
        self._frames = 0

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the frames of the last half."""
        speed = np.hstack((self._speed, np.array([rig.bit_speed, rig.top_drive_speed])))
        self._speed = speed[:, -2 * self._base :]
        for k in range(2):
            first = self.request.frames - (2 - k) * self._quarter - self._frames
            part = slice(max(0, first), max(0, first + self._quarter))
            spin = rows.spin[part]
            if spin.size:
                centre = rows.centre[part]
                terms = np.array([np.ones_like(spin), np.exp(1j * spin), centre[..., 0] + 1j * centre[..., 1]])
                self._gram[k] += np.einsum("afm,bfm->mab", terms.conj(), terms)
        self._frames += rows.time.size

    def close(self) -> Mapping[str, Variable]:
        """Radius of the rest of each mark, stick-slip index of bit and top drive, and mean speed of both."""
        rest = np.array([[_rest(gram) for gram in quarter] for quarter in self._gram])
        parts = np.split(self._speed, [max(0, self._speed.shape[1] - self._base)], axis=1)
        index = np.array([[stick_slip_index(place) if place.size else math.nan for place in part] for part in parts])
        return {
            "lateral_rest": Variable(rest.reshape(2, -1), ("quarter", "mark"), "m"),
            "stick_slip_index": Variable(index, ("time_base", "place"), "1"),
            "mean_speed": Variable(parts[1].mean(axis=1), ("place",), "rad/s"),
        }


def _rest(gram: Array) -> float:
    """Root mean square of what 1 and exp(i psi) do not explain of z, from the products of the three, shape (3, 3)."""
    samples, whole = gram[0, 0].real, gram[2, 2].real
    if not samples:
        return math.nan
    explained = np.vdot(gram[:2, 2], np.linalg.lstsq(gram[:2, :2], gram[:2, 2], rcond=1e-12)[0]).real
    return math.sqrt(max(whole - explained, ROUND_OFF**2 * whole, 0.0) / samples)
