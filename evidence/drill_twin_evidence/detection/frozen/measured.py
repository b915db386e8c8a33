# SPDX-License-Identifier: Apache-2.0
"""Times, clocks and noise of the frozen records: from a prescribed centre line to what camera and rig measure."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.frozen.truth import PER_TURN, FrozenRecord, Truth

HOLES = ((0.0718, 0.0082), (0.041, 0.009), (0.0539, 0.1016), (0.021, 0.1), (0.28, 0.11), (0.0048, 0.152))
"""Clearance and outer radius [m]: two benches, collars in two holes, pipe in a wide one, a stabiliser."""


class Turning(NamedTuple):
    """Samples of a rotation; T samples."""

    time: Array
    """True times [s], shape (T,)."""
    angle: Array
    """Angle of the rotation [rad], signed, shape (T,)."""
    speed: Array
    """Its rate [rad/s], shape (T,)."""
    sense: float
    """1 or -1."""

    @property
    def turns(self) -> Array:
        """Revolutions since the start, shape (T,)."""
        found: Array = np.abs(self.angle) / math.tau
        return found


class Errors(NamedTuple):
    """Errors of the measurement; the fields that are 0 are absent."""

    noise: float
    """White noise on each axis over the clearance."""
    colour: float = 0.0
    """Exponent of the frequency of the noise's power, 0 to 2: white, 1/f, a walk that returns."""
    step: float = 0.0
    """Quantisation over the clearance."""
    unseen: float = 0.0
    """Share of single marks that are not seen."""
    outliers: float = 0.0
    """Share of single marks at a wrong place."""


def draw_marks(
    draw: np.random.Generator, hole: int | None = None, *, inclined: bool = False, count: int | None = None
) -> tuple[MarkInfo, ...]:
    """Three to five marks in a hole."""
    clearance, outer = HOLES[int(draw.integers(len(HOLES))) if hole is None else hole]
    number = int(draw.integers(3, 6)) if count is None else count
    on_wall = draw.random() < 0.7
    return tuple(
        MarkInfo(f"mark_{k + 1}", 1.0 + k, "wall" if on_wall else "centre", outer, clearance, inclined)
        for k in range(number)
    )


def turning(draw: np.random.Generator, length: float, per_turn: float | None = None) -> Turning:
    """A constant rotation over a length [rev], with so many samples in a revolution."""
    each = float(np.exp(draw.uniform(math.log(14.0), math.log(60.0)))) if per_turn is None else per_turn
    speed, sense = float(np.exp(draw.uniform(math.log(0.7), math.log(5.0)))), float(draw.choice([-1.0, 1.0]))
    time = np.arange(int(length * each)) / (each * speed)
    return Turning(time, sense * math.tau * speed * time, np.full(time.size, sense * math.tau * speed), sense)


def draw_errors(draw: np.random.Generator, most: float = 0.03) -> Errors:
    """White noise up to `most` of the clearance, quantisation, marks that are not seen."""
    return Errors(float(draw.uniform(0.002, most)), 0.0, float(draw.uniform(0.0, 0.01)), float(draw.uniform(0.0, 0.08)))


def grid(turns: Array) -> list[int]:
    """Samples at the times of the truth."""
    cells = np.floor(turns * PER_TURN)
    return [int(i) for i in np.flatnonzero(np.diff(cells, prepend=-1.0) > 0)]


def coloured(draw: np.random.Generator, count: int, marks: int, colour: float) -> ComplexArray:
    """Complex noise of unit rms on each axis whose power falls with frequency to a power, shape (count, marks)."""
    white = draw.normal(size=(count, marks)) + 1j * draw.normal(size=(count, marks))
    if colour == 0.0:
        return white
    lines = np.abs(np.fft.fftfreq(count))
    lines[0] = lines[1]
    found: ComplexArray = np.fft.ifft(np.fft.fft(white, axis=0) * (lines ** (-0.5 * colour))[:, None], axis=0)
    even: ComplexArray = found / np.sqrt(0.5 * (np.abs(found) ** 2).mean(axis=0))
    return even


def measured(
    kind: str, name: str, marks: tuple[MarkInfo, ...], samples: Turning, centre: ComplexArray, truth: Truth,
    errors: Errors, draw: np.random.Generator, *, stamps: Array | None = None, kept: NDArray[np.int64] | None = None,
    sees_spin: bool | None = None, spin: Array | None = None,
) -> FrozenRecord:  # fmt: skip
    """Record of a centre line over the clearance.

    Args:
        kind: Letter of the kind.
        name: Name of the record.
        marks: The marks.
        samples: Times and rotation.
        centre: Centre line over the clearance, shape (T, m).
        truth: What is true of it.
        errors: Errors of the measurement.
        draw: Source of random numbers.
        stamps: Stamps that a clock gives the samples [s], shape (T,); the true times unless given.
        kept: Numbers of the samples that arrive, in their order; all unless given.
        sees_spin: Whether the spin is measured; drawn unless given.
        spin: Spin at the marks [rad], shape (T, m); that of the rotation, twisted, unless given.
    """
    scale, shape = np.array([mark.clearance for mark in marks]), centre.shape
    if spin is None:
        spin = samples.angle[:, None] - samples.sense * 0.3 * np.arange(len(marks))
    arm = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks])
    z = scale * (centre + errors.noise * coloured(draw, shape[0], shape[1], errors.colour)) + arm * np.exp(1j * spin)
    if errors.step:
        step = errors.step * scale
        z = step * (np.round(z.real / step) + 1j * np.round(z.imag / step))
    wrong = draw.random(shape) < errors.outliers
    z = np.where(wrong, z + scale * (draw.normal(size=shape) + 1j * draw.normal(size=shape)), z)
    z[draw.random(shape) < errors.unseen] = math.nan
    seen = draw.random() < 0.75 if sees_spin is None else sees_spin
    rows = np.arange(shape[0]) if kept is None else kept
    stamp = np.round((samples.time if stamps is None else stamps) * 1e9).astype(np.int64)
    return FrozenRecord(
        kind, name, marks, stamp[rows], np.stack((z.real, z.imag), axis=-1)[rows], spin[rows] if seen else None,
        samples.speed[rows], truth,
    )  # fmt: skip
