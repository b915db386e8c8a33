# SPDX-License-Identifier: Apache-2.0
"""Prescribed motions of the frozen records: paths of unit amplitude, shapes over the marks, growth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.frozen.measured import Turning, grid
from drill_twin_evidence.detection.frozen.truth import (
    BACKWARD,
    BENDING,
    CREEP,
    FIXED,
    FORWARD,
    IMPACTS,
    IRREGULAR,
    ROLLING,
    SPIRAL,
    SWING,
    WHIRLS,
    Truth,
)  # fmt: skip

AT_WALL = {ROLLING, CREEP, IMPACTS}
"""States that are true only once the orbit has grown to the wall."""
CHANGE = 2.0
"""Length of the change from one motion to another [rev]."""


class Motion(NamedTuple):
    """A motion of the string."""

    state: str
    ratio: float | None
    """Whirl ratio of the larger orbit."""
    path: ComplexArray
    """Path whose circular parts have squares that sum to 1, shape (T,)."""
    level: float
    """Amplitude over the clearance when fully grown."""
    shape: ComplexArray
    """Factor of each mark, shape (m,)."""
    scored: bool = True

    def of_mark(self, mark: int) -> str:
        """State of a mark; empty where it moves too little to say."""
        if abs(self.shape[mark]) < 0.3:
            return ""
        if self.state in {BENDING, SPIRAL}:
            return BACKWARD if self.ratio is not None and self.ratio < 0.0 else FORWARD
        return self.state


def ellipse(samples: Turning, ratio: float, axis_ratio: float, draw: np.random.Generator) -> ComplexArray:
    """Ellipse that goes round at a ratio to the rotation, with half axes of a ratio from 0, a plane, to 1."""
    phase = ratio * samples.angle + draw.uniform(0.0, math.tau)
    path = np.cos(phase) + 1j * axis_ratio * np.sin(phase)
    found: ComplexArray = np.exp(1j * draw.uniform(0.0, math.tau)) * path / math.sqrt(0.5 * (1.0 + axis_ratio**2))
    return found


def wandering(samples: Turning, draw: np.random.Generator) -> ComplexArray:
    """Irregular path: forty lines at up to 1.3 of the rotation, either way."""
    pace, phase = draw.uniform(-1.3, 1.3, 40), draw.uniform(0.0, math.tau, 40)
    found: ComplexArray = np.exp(1j * (samples.angle[:, None] * pace + phase)).sum(axis=1) / math.sqrt(40.0)
    return found


def bouncing(samples: Turning, ratio: float, draw: np.random.Generator) -> ComplexArray:
    """Path that goes round, flies off the wall and strikes it, 1.5 to 5 times a revolution; largest radius 1."""
    count, depth, each = int(samples.turns[-1] * 6) + 2, draw.uniform(0.25, 0.6), draw.uniform(0.2, 0.65)
    edges = np.concatenate(([0.0], np.cumsum(each * draw.uniform(0.7, 1.3, count))))
    edges = edges[: int(np.searchsorted(edges, samples.turns[-1])) + 1]
    at = np.searchsorted(edges, samples.turns, side="right") - 1
    lengths = np.append(np.diff(edges), each)
    share = np.clip((samples.turns - edges[at]) / lengths[at], 0.0, 1.0)
    height = depth * (lengths[at] / each) ** 2
    found: ComplexArray = (1.0 - np.minimum(height * 4.0 * share * (1.0 - share), 0.9)) * np.exp(
        1j * (ratio * samples.angle + draw.uniform(0.0, math.tau))
    )
    return found


def draw_motion(
    state: str, samples: Turning, marks: Sequence[MarkInfo], draw: np.random.Generator, slowest: float = 0.02
) -> Motion:
    """A whirl of a state with a random ratio, amplitude and shape; `slowest`: ratio of the slowest creep."""
    m, rolling = len(marks), marks[0].rolling_ratio
    ratio = float(draw.choice([draw.uniform(0.12, 0.85), draw.uniform(1.15, 1.8), -draw.uniform(0.1, 1.3)]))
    level, along = float(draw.uniform(0.15, 0.8)), np.linspace(0.0, 1.0, m)
    shape = (1.0 - draw.uniform(0.0, 0.5) * along) * np.exp(1j * draw.uniform(-0.15, 0.15, m))
    if state == FORWARD:
        ratio = abs(ratio)
    elif state == BACKWARD:
        ratio = -abs(ratio)
    elif state == BENDING:
        shape = (1.0 - draw.uniform(1.6, 2.0) * along).astype(complex)
    elif state == SPIRAL:
        shape = np.exp(1j * float(draw.choice([-1.0, 1.0])) * math.pi * draw.uniform(0.9, 1.15) * np.arange(m) / m)
    elif state in AT_WALL:
        level, shape = 1.0, np.exp(1j * draw.uniform(-0.1, 0.1, m))
        if state == ROLLING:
            ratio = rolling * float(draw.uniform(0.9, 1.1))
        elif state == CREEP:
            ratio = -float(np.exp(draw.uniform(math.log(slowest), math.log(min(0.3, -0.3 * rolling)))))
    elif state == IRREGULAR:
        return Motion(state, None, wandering(samples, draw), float(draw.uniform(0.25, 0.45)), shape)
    if state == IMPACTS:
        return Motion(state, ratio, bouncing(samples, ratio, draw), level, shape)
    return Motion(state, ratio, ellipse(samples, ratio, 1.0, draw), level, shape)


def exponential(samples: Turning, level: float, growth: float, quiet: float, *, to_wall: bool = False) -> Array:
    """Amplitude that is 0.004 at `quiet` [rev] and grows by e in 1/growth [rev] to a level, shape (T,)."""
    grown = 0.004 * np.exp(np.minimum(growth * (samples.turns - quiet), 50.0))
    found: Array = np.minimum(grown, level) if to_wall else grown / (1.0 + grown / level)
    return found


def linear(samples: Turning, level: float, slope: float, quiet: float) -> Array:
    """Amplitude that begins at `quiet` [rev] and grows by `slope` in a revolution to a level, shape (T,)."""
    found: Array = np.clip(slope * (samples.turns - quiet), 1e-6, level)
    return found


def assembled(
    samples: Turning, motions: Sequence[Motion], size: Array, change: float = math.inf, stamps: Array | None = None
) -> tuple[ComplexArray, Truth]:
    """Motion of the marks over the clearance, shape (T, m), and what is true of it.

    Args:
        samples: Times and rotation.
        motions: One motion, or two of which the second takes the place of the first.
        size: Amplitude of the first motion, shape (T,).
        change: Time of the change to the second [rev].
        stamps: Stamps that a clock gives the samples [s], shape (T,).
    """
    first, last = motions[0], motions[-1]
    change = math.inf if first is last else change
    x = np.clip((samples.turns - change) / CHANGE + 0.5, 0.0, 1.0)
    share = x * x * (3.0 - 2.0 * x)
    sizes = ((1.0 - share) * size, share * last.level)
    part = sizes[0][:, None] * first.path[:, None] * first.shape
    if len(motions) > 1:
        part = part + sizes[1][:, None] * last.path[:, None] * last.shape
    at = grid(samples.turns)
    amplitude = np.hypot(sizes[0][at, None] * np.abs(first.shape), sizes[1][at, None] * np.abs(last.shape))

    def names(of: Sequence[str]) -> tuple[str, ...]:
        found = []
        for i in at:
            own = of[0] if samples.turns[i] < change else of[-1]
            mixed = 0.0 < share[i] < 1.0
            grows = share[i] == 0.0 and first.state in AT_WALL and size[i] < first.level
            # What has not begun is no whirl in any case, which `Truth` says by the amplitude.
            found.append("" if mixed or (grows and size[i] > 0.02) else own)
        return tuple(found)

    whirls = first.state in WHIRLS
    still = np.zeros_like(amplitude)
    truth = Truth(
        (samples.time if stamps is None else stamps)[at], samples.turns[at], amplitude if whirls else still,
        still if whirls else amplitude, names([motion.state for motion in motions]),
        tuple(names([motion.of_mark(k) for motion in motions]) for k in range(first.shape.size)),
        last.ratio if whirls and first is last else None, all(motion.scored for motion in motions),
    )  # fmt: skip
    return part, truth


def resting(samples: Turning, draw: np.random.Generator, aside: float, bow: float, marks: int) -> ComplexArray:
    """Offset and bow of a string over the clearance, at most so large, shape (T, marks)."""
    offset = draw.uniform(0.0, aside) * np.exp(1j * draw.uniform(0.0, math.tau))
    turn = np.exp(1j * (samples.angle[:, None] - samples.sense * 0.3 * np.arange(marks) + draw.uniform(0.0, math.tau)))
    found: ComplexArray = offset + draw.uniform(0.0, bow) * turn
    return found


def within(centre: ComplexArray) -> ComplexArray:
    """The centre line, held by the wall."""
    found: ComplexArray = centre / np.maximum(np.abs(centre), 1.0)
    return found


__all__ = [
    "AT_WALL", "FIXED", "SWING", "Motion", "assembled", "bouncing", "draw_motion", "ellipse", "exponential", "linear",
    "resting", "wandering", "within",
]  # fmt: skip
