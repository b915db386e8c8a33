# SPDX-License-Identifier: Apache-2.0
"""Lateral motion of the members, as complex numbers x + i y: read, turned about the axis of the hole, written back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.sensors.motion import locate
from drill_twin.dynamics.sensors.subs import gravity_of
from drill_twin.dynamics.twin.frame_record import FrameSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene

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


class LateralMotion:
    """Lateral motion of twins of one scene: places and slopes of the n + 1 nodes, and their velocities.

    Attributes:
        turns_freely: Whether the motion may be turned about the axis of the hole: it is straight and vertical.
    """

    def __init__(self, scene: Scene, twin: Twin) -> None:
        self._rod = rod = twin.rod
        self._spatial = twin.dynamics.form != LATERAL
        self._held_top = scene.rig.weight_on_bit.at != "top"
        self._clearance = np.array([scene.clearance_at(arc) for arc in rod.arc.tolist()])
        arcs = np.array([mark.distance_from_bit for mark in scene.string.marks])
        self._marks = locate(rod, arcs, np.zeros_like(arcs), np.zeros_like(arcs))
        self.turns_freely = not scene.hole.survey and not np.any(gravity_of(scene)[:2])

    def read(self, twins: Sequence[Twin]) -> ComplexArray:
        """Places and slopes, then their velocities, shape (N, 2, n + 1, 2)."""
        return np.array([[rows[:, (0, 3)] + 1j * rows[:, (1, 4)] for rows in twin.unknowns] for twin in twins])

    def marks(self, motion: ComplexArray) -> ComplexArray:
        """Places of the centre line at the marks [m], shape (N, m)."""
        low, shape = self._marks.element, self._marks.shape[:, 0]
        ends = np.concatenate((motion[:, 0, low], motion[:, 0, low + 1]), axis=-1)
        return np.asarray((shape * ends).sum(-1))

    def write(self, twins: Sequence[Twin], motion: ComplexArray) -> None:
        """Give the twins another lateral motion, of `read`.

        Nodes stay in the hole. Stretch is kept, as the axial motion follows the lateral one within the time of a wave
        (a bent string is shorter): slopes z' keep the length of r', and nodes move along the hole as far as the string
        between them and the held end has become shorter.
        """
        before = self.read(twins)
        size = np.abs(motion[:, 0, :, 0])
        with np.errstate(divide="ignore", invalid="ignore"):
            motion[:, 0, :, 0] *= np.where(size > self._clearance, self._clearance / size, 1.0)
        for twin, old, new in zip(twins, before, motion, strict=True):
            for rows, values in zip(twin.unknowns, new, strict=True):
                rows[:, (0, 3)], rows[:, (1, 4)] = values.real, values.imag
            if self._spatial:
                rows = twin.unknowns[0]
                square = rows[:, 5] ** 2 + np.abs(old[0, :, 1]) ** 2 - np.abs(new[0, :, 1]) ** 2
                rows[:, 5] = np.copysign(np.sqrt(np.maximum(square, 0.0)), rows[:, 5])
                moved = np.append(0.0, np.cumsum(self._lost(old[0]) - self._lost(new[0])))
                rows[:, 2] += moved - moved[-1] if self._held_top else moved

    def _lost(self, motion: ComplexArray) -> Array:
        """Length of each element less its extent along the hole [m], of its places and slopes, shape (n,)."""
        slope = (self._rod.shape[:, :, 1] * np.hstack((motion[:-1], motion[1:]))[:, None]).sum(-1)
        cosine = np.sqrt(np.maximum(1.0 - np.abs(slope) ** 2, 0.0))
        return np.asarray(self._rod.length * np.mean(1.0 - cosine, axis=1))  # two Gauss points of equal weight
