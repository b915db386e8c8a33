# SPDX-License-Identifier: Apache-2.0
"""Spectra of the motion at the marks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.outputs.collector import Collector, Request, Variable

SEGMENT = 1024
"""Frames of a segment of a spectrum."""


class Spectra(Collector):
    """Two-sided spectrum of the centre line at each mark (Welch 1967: Hann windows, half overlap, mean power).

    A circular orbit has a line as high as its radius, at a positive frequency if it is forward.
    """

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._length = min(SEGMENT, request.frames)
        self._window = np.hanning(self._length + 1)[:-1] if self._length > 1 else np.ones(1)
        marks = len(twin.scene.string.marks)
        self._power, self._segments = np.zeros((self._length, marks)), 0
        self._waiting = np.zeros((0, marks), complex)

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Transform the segments that are full."""
        del rig
        line = rows.centre[..., 0] + 1j * rows.centre[..., 1]
        waiting, length = np.concatenate((self._waiting, line)), self._length
        while len(waiting) >= length:
            segment = waiting[:length]
            spectrum = np.fft.fft((segment - segment.mean(axis=0)) * self._window[:, None], axis=0)
            self._power += np.abs(spectrum / self._window.sum()) ** 2
            self._segments += 1
            waiting = waiting[max(1, length // 2) :]
        self._waiting = waiting

    def close(self) -> Mapping[str, Variable]:
        """Frequencies and radii."""
        frequency = np.fft.fftshift(np.fft.fftfreq(self._length, self.request.period))
        power = np.fft.fftshift(self._power / max(self._segments, 1), axes=0)
        return {
            "frequency": Variable(frequency, ("frequency",), "rev/s"),
            "spectrum": Variable(np.sqrt(power), ("frequency", "mark"), "m"),
        }
