# SPDX-License-Identifier: Apache-2.0
"""Outputs of a member, gathered chunk by chunk; but for `marks` and `channels` memory does not grow with the run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import tubes_of
from drill_twin.errors import ArgumentError
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.model.mesh import SPIN
from drill_twin.model.section_stress import CYCLES, DAMAGE, LARGEST_STRESS
from drill_twin.twin.bending_stress import bending_stress
from drill_twin.twin.frame_kernel import Rows
from drill_twin.twin.observer import RigRows, rig_rows
from drill_twin.twin.twin import Twin
from drill_twin.whirl import Analyzer, BitOnlyAnalyzer, Summary

SEGMENT = 1024
"""Frames of a segment of a spectrum."""
_CHANNEL_UNITS = {"top_drive_torque": "N m", "motor_torque": "N m", "bit_torque": "N m", "top_drive_speed": "rad/s",
                  "bit_speed": "rad/s"}  # fmt: skip


@dataclass(frozen=True)
class Request:
    """Outputs asked for, the same for all members.

    Attributes:
        names: Names of the outputs, of `OUTPUTS`.
        period: Length of a frame [s].
        frames: Frames of a run.
        every: Frames from one sample of the marks to the next.
    """

    names: tuple[str, ...]
    period: float
    frames: int
    every: int


class Variable(NamedTuple):
    """Value of one member."""

    value: Any
    dimensions: tuple[str, ...]
    unit: str


class Collector:
    """Gathers one output of a member."""

    def __init__(self, twin: Twin, request: Request) -> None:
        """Begin with the first frame."""
        self.twin, self.request = twin, request

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Add the next frames."""

    def close(self) -> Mapping[str, Variable]:
        """Values of the whole run, by name."""
        raise NotImplementedError


class Findings(Collector):
    """Whirl analysis, as the analyzer node makes it of the messages."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        infos = mark_infos(twin.scene)
        self._analyzer = Analyzer(infos) if infos else None
        self._bit = BitOnlyAnalyzer()

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Add a sample for each frame."""
        stamps = [stamp_ns(time) for time in rows.time.tolist()]
        if self._analyzer is None:
            for sample in zip(stamps, rig.top_drive_speed.tolist(), rig.bit_speed.tolist(), strict=True):
                self._bit.push(*sample)
            return
        outwards = rows.centre[:, :, :2]
        radius = np.maximum(np.hypot(outwards[..., 0], outwards[..., 1]), np.finfo(float).tiny)
        effort = -(rows.wall_force / radius)[..., None] * outwards  # as `/marks/state` has it
        force = np.hypot(effort[..., 0], effort[..., 1])
        self._analyzer.push_block(np.array(stamps), rows.position, rows.spin, rig.top_drive_speed, force, rig.bit_speed)

    def close(self) -> Mapping[str, Variable]:
        """Onset, motion and precession; `summary` has the rest."""
        found: Summary = self._bit.summary() if self._analyzer is None else self._analyzer.summary()
        return {
            "onset_s": Variable(_number(found.onset_s), (), "s"),
            "motion": Variable(found.motion[-1].state.value if found.motion else "unknown", (), ""),
            "whirl_frequency_hz": Variable(_number(found.whirl_frequency_hz), (), "rev/s"),
            "precession_ratio": Variable(_number(found.precession_ratio), (), "1"),
            "summary": Variable(found, (), ""),
        }


class Marks(Collector):
    """Centre line at the marks at a rate."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        samples, marks = math.ceil(request.frames / request.every), len(twin.scene.string.marks)
        self._time, self._centre = np.full(samples, np.nan), np.full((samples, marks, 2), np.nan)
        self._frames = self._samples = 0

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Keep every n-th frame."""
        del rig
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

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._rows: list[Array] = []
        self._speeds = np.array((twin.unknowns[1][-1, SPIN], twin.unknowns[1][0, SPIN]))

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Add the frames: means of the forces as they are, of the speeds from those at their ends."""
        drive = self.twin.scene.rig.top_drive
        speeds = np.column_stack((self._speeds, (rig.top_drive_speed, rig.bit_speed)))
        top, bit = 0.5 * (speeds[:, 1:] + speeds[:, :-1])
        motor = rig.top_drive_torque + drive.inertia * np.diff(speeds[0]) / self.request.period + drive.damping * top
        self._speeds = speeds[:, -1]
        means = rig._replace(top_drive_speed=top, bit_speed=bit)
        self._rows.append(np.array((rows.time, *means, motor)))

    def close(self) -> Mapping[str, Variable]:
        """Times of the ends of the samples, and values by channel."""
        every, samples = self.request.every, self.request.frames // self.request.every
        table = np.full((len(RigRows._fields) + 2, samples), np.nan)
        frames = np.concatenate(self._rows, axis=1)
        count = frames.shape[1] // every
        parts = frames[:, : count * every].reshape(len(table), count, every)
        table[:, :count] = parts.mean(axis=2)
        table[0, :count] = parts[0, :, -1]
        time, *values = table
        names = (*RigRows._fields, "motor_torque")
        return {"time": Variable(np.round(time, 9), ("sample",), "s")} | {
            name.replace("top_drive_torque", "torque"): Variable(value, ("sample",), _CHANNEL_UNITS.get(name, "N"))
            for name, value in zip(names, values, strict=True)
        }


class Extremes(Collector):
    """Largest and smallest values of the run."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._largest: dict[str, Any] = {}
        self._smallest: dict[str, Any] = {}

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Compare with the extremes so far."""
        largest = {
            "radius": np.hypot(rows.centre[..., 0], rows.centre[..., 1]),
            "wall_force": rows.wall_force,
            "string_wall_force": rows.string[:, 0],
            "penetration": rows.string[:, 1],
        }
        both = {"torque": rig.top_drive_torque, "bit_torque": rig.bit_torque, "hookload": rig.hookload,
                "bit_speed": rig.bit_speed}  # fmt: skip
        for name, values in (largest | both).items():
            self._largest[name] = np.maximum(self._largest.get(name, -np.inf), values.max(axis=0))
        for name, values in both.items():
            self._smallest[name] = np.minimum(self._smallest.get(name, np.inf), values.min(axis=0))

    def close(self) -> Mapping[str, Variable]:
        """Extremes by name."""
        units = {"radius": "m", "penetration": "m", "torque": "N m", "bit_torque": "N m", "bit_speed": "rad/s"}
        of_marks = {"radius", "wall_force"}

        def variables(found: Mapping[str, Any], suffix: str) -> dict[str, Variable]:
            return {
                f"{name}_{suffix}": Variable(value, ("mark",) if name in of_marks else (), units.get(name, "N"))
                for name, value in found.items()
            }

        return {**variables(self._largest, "max"), **variables(self._smallest, "min")}


class LastHalf(Collector):
    """Severity of the motion once it has settled: extremes of the last half of the run."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._frames = 0
        self._radius: Any = 0.0
        self._force = 0.0
        self._torque = (math.inf, -math.inf)

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Compare the frames after the middle of the run."""
        first = max(0, self.request.frames // 2 - self._frames)
        self._frames += rows.time.size
        if first < rows.time.size:
            self._radius = np.maximum(
                self._radius, np.hypot(rows.centre[first:, :, 0], rows.centre[first:, :, 1]).max(0)
            )
            self._force = max(self._force, float(rows.string[first:, 0].max()))
            torque, (low, high) = rig.top_drive_torque[first:], self._torque
            self._torque = min(low, float(torque.min())), max(high, float(torque.max()))

    def close(self) -> Mapping[str, Variable]:
        """Radius of the marks, wall force, swing of the torque; bending stress at the last instant."""
        low, high = self._torque
        dynamics = self.twin.dynamics
        stress = bending_stress(dynamics.rod, tubes_of(self.twin.scene), dynamics.unknowns[0])
        radius = np.broadcast_to(self._radius, (len(self.twin.scene.string.marks),)).copy()
        return {
            "radius_late": Variable(radius, ("mark",), "m"),
            "wall_force_late": Variable(self._force, (), "N"),
            "torque_swing_late": Variable(high - low if high >= low else math.nan, (), "N m"),
            "bending_stress_end": Variable(float(stress.max()), (), "Pa"),
        }


class Fatigue(Collector):
    """Stress and damage of the sections of scenes with the effect `fatigue`."""

    def close(self) -> Mapping[str, Variable]:
        """Largest stress, cycles and damage of the whole run."""
        found = self.twin.dynamics.stress
        if found is None:
            raise ArgumentError("outputs: expected a scene with effects.fatigue for `fatigue`, found none")
        columns = (("largest_stress", LARGEST_STRESS, "Pa"), ("stress_cycles", CYCLES, "1"), ("damage", DAMAGE, "1"))
        return {name: Variable(found[:, column].copy(), ("section",), unit) for name, column, unit in columns}


class Contact(Collector):
    """Share of the frames with contact at each mark, and mean share of the nodes in contact."""

    _touching: Any = 0
    _nodes = 0.0
    _frames = 0

    def add(self, rows: Rows, rig: RigRows) -> None:
        """Count frames with contact."""
        del rig
        self._touching = self._touching + (rows.wall_force > 0.0).sum(axis=0)
        self._nodes += float(rows.string[:, 2].sum())
        self._frames += rows.time.size

    def close(self) -> Mapping[str, Variable]:
        """Shares."""
        return {
            "contact_share": Variable(self._touching / self._frames, ("mark",), "1"),
            "string_contact_share": Variable(self._nodes / self._frames, (), "1"),
        }


class Energy(Collector):
    """Energy balance at the end, of scenes with `numerics.audit: energy`."""

    def close(self) -> Mapping[str, Variable]:
        """Dissipation by effect, work, and the residual."""
        found = self.twin.energy()
        if found is None:
            raise ArgumentError("outputs: expected a scene with numerics.audit: energy for `energy`, found none")
        parts = {f"dissipated_{name}": value for name, value in found.dissipated.items()}
        parts |= {f"work_{name}": value for name, value in found.work.items()}
        parts |= {f"stored_{name}": value for name, value in found.stored.items()}
        return {
            **{f"energy_{name}": Variable(value, (), "J") for name, value in parts.items()},
            "energy_residual": Variable(found.share, (), "1"),
        }


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

    def add(self, rows: Rows, rig: RigRows) -> None:
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


OUTPUTS: Mapping[str, type[Collector]] = {
    "findings": Findings,
    "extremes": Extremes,
    "contact": Contact,
    "last_half": LastHalf,
    "marks": Marks,
    "channels": Channels,
    "spectra": Spectra,
    "energy": Energy,
    "fatigue": Fatigue,
}
"""Outputs by name."""


def collect(collectors: list[Collector], twin: Twin, rows: Rows, period: float) -> None:
    """Give frames of a length [s] to all collectors."""
    if rows.time.size:
        rig = rig_rows(twin.dynamics, rows, period)
        for collector in collectors:
            collector.add(rows, rig)


def first_rows(rows: Rows, count: int) -> Rows:
    """The first frames of a record; views."""
    return Rows(*(column[:count] for column in rows))


def _number(value: float | None) -> float:
    return math.nan if value is None else value
