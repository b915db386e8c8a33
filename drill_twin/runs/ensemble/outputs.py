# SPDX-License-Identifier: Apache-2.0
"""Outputs of a member, gathered chunk by chunk: over time here, of the run as a whole in `run_outputs`.

Memory grows with the run for `marks` and the channels only.
"""

import math
from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array, number_or_nan
from drill_twin.core.rig_channels import INSTANT, channel_of
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.io.messages.encode import wall_push
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.physics.model.mesh import SPIN
from drill_twin.runs.ensemble.run_outputs import (
    Collector,
    Contact,
    Energy,
    Extremes,
    Fatigue,
    LastHalf,
    Request,
    Settling,
    Variable,
)
from drill_twin.whirl import Analyzer, BitOnlyAnalyzer, Summary

__all__ = ["OUTPUTS", "Collector", "Request", "Variable"]


class Marks(Collector):
    """Centre line at the marks at a rate."""

    def begin(self) -> None:
        """Prepare for the first frame."""
        samples, marks = math.ceil(self.request.frames / self.request.every), len(self.twin.scene.string.marks)
        self._time, self._centre = np.full(samples, np.nan), np.full((samples, marks, 2), np.nan)
        self._frames = self._samples = 0

    def add(self, rows: FrameSeries, _rig: RigSeries) -> None:
        """Keep every n-th frame."""
        first = -self._frames % self.request.every
        time, centre = rows.time[first :: self.request.every], rows.centre[first :: self.request.every, :, :2]
        place = slice(self._samples, self._samples + time.size)
        self._time[place], self._centre[place] = time, centre
        self._frames += rows.time.size
        self._samples += time.size

    def close(self) -> Mapping[str, Variable]:
        """Times and positions."""
        return {
            "time": Variable(np.round(self._time, 9), ("sample",), "s"),
            "centre": Variable(self._centre, ("sample", "mark", "axis"), "m"),
        }


class Channels(Collector):
    """Channels that a rig measures, each the mean since the last sample; `motor_torque` is with the drive's inertia."""

    suffix = ""
    """Ending of the names of the channels: empty where the values are means."""

    def begin(self) -> None:
        """Prepare for the first frame."""
        self._rows: list[Array] = []
        self._speeds = self.twin.unknowns[1][[-1, 0], SPIN]

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the frames: forces are means over a frame already, speeds are averaged from both ends of a frame."""
        drive = self.twin.scene.rig.top_drive
        speeds = np.column_stack((self._speeds, (rig.top_drive_speed, rig.bit_speed)))
        top, bit = 0.5 * (speeds[:, 1:] + speeds[:, :-1])
        motor = rig.top_drive_torque + drive.inertia * np.diff(speeds[0]) / self.request.period + drive.damping * top
        self._speeds = speeds[:, -1]
        of_frames = rig if self.suffix else rig._replace(top_drive_speed=top, bit_speed=bit)
        self._rows.append(np.array((rows.time, *of_frames, motor)))

    def close(self) -> Mapping[str, Variable]:
        """Times of the ends of the samples, and values by channel."""
        every, samples = self.request.every, self.request.frames // self.request.every
        table = np.full((len(RigSeries._fields) + 2, samples), np.nan)
        frames = np.concatenate(self._rows, axis=1)
        count = frames.shape[1] // every
        parts = frames[:, : count * every].reshape(len(table), count, every)
        table[:, :count] = parts[:, :, -1] if self.suffix else parts.mean(axis=2)
        table[0, :count] = parts[0, :, -1]
        time, *values = table
        names = [name.replace("top_drive_torque", "torque") for name in (*RigSeries._fields, "motor_torque")]
        return {"time": Variable(np.round(time, 9), ("sample",), "s")} | {
            f"{name}{self.suffix}": Variable(value, ("sample",), channel_of(name).dimension.unit)
            for name, value in zip(names, values, strict=True)
        }


class Instants(Channels):
    """The same channels at the ends of the samples, named CHANNEL@instant; forces and torques over the last frame."""

    suffix = INSTANT


SEGMENT = 1024
"""Frames of a segment of a spectrum."""


class Spectra(Collector):
    """Two-sided spectrum of the centre line at each mark (Welch 1967: Hann windows, half overlap, mean power).

    A circular orbit has a line as high as its radius, at a positive frequency if it is forward.
    """

    def begin(self) -> None:
        """Prepare for the first frame."""
        self._length = min(SEGMENT, self.request.frames)
        self._window = np.hanning(self._length + 1)[:-1] if self._length > 1 else np.ones(1)
        marks = len(self.twin.scene.string.marks)
        self._power, self._segments = np.zeros((self._length, marks)), 0
        self._waiting = np.zeros((0, marks), complex)

    def add(self, rows: FrameSeries, _rig: RigSeries) -> None:
        """Transform the segments that are full."""
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


class Findings(Collector):
    """Whirl analysis, as the analyzer node makes it of the messages."""

    def begin(self) -> None:
        """Prepare for the first frame."""
        infos = mark_infos(self.twin.scene)
        self._analyzer = Analyzer(infos) if infos else None
        self._bit = BitOnlyAnalyzer()

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add a sample for each frame."""
        stamps = [stamp_ns(time) for time in rows.time.tolist()]
        if self._analyzer is None:
            for sample in zip(stamps, rig.top_drive_speed.tolist(), rig.bit_speed.tolist(), strict=True):
                self._bit.push(*sample)
            return
        push = wall_push(rows.centre, rows.wall_force)  # as `/marks/state` has it
        force = np.hypot(push[..., 0], push[..., 1])
        self._analyzer.push_block(np.array(stamps), rows.position, rows.spin, rig.top_drive_speed, force, rig.bit_speed)

    def close(self) -> Mapping[str, Variable]:
        """Onset, motion and precession; `summary` has the rest."""
        found: Summary = self._bit.summary() if self._analyzer is None else self._analyzer.summary()
        return {
            "onset_s": Variable(number_or_nan(found.onset_s), (), "s"),
            "motion": Variable(found.motion[-1].state.value if found.motion else "unknown", (), ""),
            "whirl_frequency_hz": Variable(number_or_nan(found.whirl_frequency_hz), (), "rev/s"),
            "whirl_ratio": Variable(number_or_nan(found.whirl_ratio), (), "1"),
            "summary": Variable(found, (), ""),
        }


OUTPUTS: Mapping[str, type[Collector]] = {
    "findings": Findings,
    "extremes": Extremes,
    "contact": Contact,
    "last_half": LastHalf,
    "settling": Settling,
    "marks": Marks,
    "channels": Channels,
    "instants": Instants,
    "spectra": Spectra,
    "energy": Energy,
    "fatigue": Fatigue,
}
"""Outputs by name."""
