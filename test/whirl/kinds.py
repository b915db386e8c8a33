# SPDX-License-Identifier: Apache-2.0
"""Motions of each kind, drawn by a seed: rates, noise, inclination, gaps and jitter as they come.

Every truth is by construction: an orbit is prescribed by its two half axes, its pace and its place in the hole. Nothing
here is of `drill_twin.whirl` but its input and its names. `python kinds.py 0 500` prints a table of kinds and findings.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass

import numpy as np

from drill_twin.whirl import Analyzer, MarkInfo, MotionState

TURN = 2.0 * np.pi
BEGIN = 12.0
"""Revolutions after which a motion begins to grow."""
S = MotionState
WHIRLS = {S.FORWARD_WHIRL, S.BACKWARD_WHIRL, S.ROLLING, S.CREEPING, S.IMPACTS, S.IRREGULAR, S.SYNCHRONOUS_WHIRL}
EXPECTED = {
    "still": {S.FIXED_AXIS},
    "plane": {S.PLANE_SWING},
    "plane once a turn": {S.PLANE_SWING},
    "arc": {S.PLANE_SWING},
    "ellipse forward": {S.FORWARD_WHIRL},
    "ellipse backward": {S.BACKWARD_WHIRL},
    "forward": {S.FORWARD_WHIRL},
    "backward": {S.BACKWARD_WHIRL},
    "creeping": {S.CREEPING},
    "rolling": {S.ROLLING},
    "impacts": {S.IMPACTS},
    "two whirls": {S.FORWARD_WHIRL, S.BACKWARD_WHIRL},
    "irregular": {S.IRREGULAR},
    "synchronous": {S.SYNCHRONOUS_WHIRL},
}
"""Kinds, and the states that are right."""
CALM = {"still", "plane", "plane once a turn", "arc"}
"""Kinds without whirl."""


@dataclass(frozen=True)
class Drawn:
    """A drawn record of one mark, of n samples; lengths over the clearance, times in revolutions."""

    kind: str
    mark: MarkInfo
    time: np.ndarray  # (n,) [s]
    angle: np.ndarray  # (n,) of rotation [rad]
    centre: np.ndarray  # (n,) complex: centre line
    noise: float
    ratio: float  # of the stronger line
    force: np.ndarray | None  # (n,) wall force [N]
    seed: int

    def analysed(self) -> Analyzer:
        """Analyzer after the record."""
        draw = np.random.default_rng([self.seed, 1])
        shape = self.time.shape
        z = self.centre + self.noise * (draw.normal(size=shape) + 1j * draw.normal(size=shape))
        z = z * self.mark.clearance + self.mark.wall_offset * np.exp(1j * self.angle)
        place = np.stack((z.real, z.imag), axis=-1)[:, None]
        analyzer = Analyzer([self.mark])
        force = None if self.force is None else self.force[:, None]
        speed = np.full(shape, (self.angle[-1] - self.angle[0]) / (self.time[-1] - self.time[0]))
        analyzer.push_block(np.round(self.time * 1e9).astype(np.int64), place, self.angle[:, None], speed, force)
        return analyzer


def _ellipse(turned, major, minor, phase, direction):
    """Orbit with half axes; a negative `minor` is backward."""
    theta = turned + phase
    return (major * np.cos(theta) + 1j * minor * np.sin(theta)) * np.exp(1j * direction)


def drawn(kind: str, seed: int) -> Drawn:
    """The record of a kind and a seed."""
    draw = np.random.default_rng([seed, sorted(EXPECTED).index(kind)])
    speed, clearance, inclined = draw.uniform(0.7, 3.5), draw.uniform(0.01, 0.1), bool(draw.random() < 0.4)
    inclined = inclined and kind != "irregular"
    roll = float(np.exp(draw.uniform(np.log(0.3), np.log(20.0 if kind == "creeping" else 50.0))))
    ratio = float(draw.uniform(0.15, 0.8) if draw.random() < 0.6 else draw.uniform(1.25, 3.0))
    if kind in {"ellipse backward", "backward"} or (kind in {"impacts", "two whirls"} and draw.random() < 0.5):
        ratio = -float(draw.uniform(0.1, 3.0))
    if kind == "rolling":
        ratio = -roll * float(draw.uniform(0.8, 1.15))
    elif kind == "creeping":
        ratio = -min(roll * float(draw.uniform(0.02, 0.4)), 3.0)
        ratio = -max(-ratio, 0.03)
        roll = max(roll, 2.6 * abs(ratio))  # slip above 0.6
    elif kind == "plane once a turn":
        ratio = 1.0
    rate = speed * max(16.0, 3.2 * abs(ratio), 2.7 * roll) * float(np.exp(draw.uniform(0.0, 1.5)))
    seconds = (BEGIN + 40.0 + (20.0 if abs(ratio) < 0.1 else 0.0)) / speed
    time = np.arange(round(seconds * rate)) / rate
    time = np.sort(time + draw.uniform(0.0, 0.3) / rate * draw.normal(size=time.size))
    time -= time[0]
    keep = draw.random(time.size) >= draw.uniform(0.0, 0.12)
    if draw.random() < 0.3:
        hole = draw.uniform(BEGIN + 8.0, BEGIN + 12.0) / speed
        keep &= np.abs(time - hole) > 0.5 * draw.uniform(0.2, 0.7) / speed
    time = time[keep]
    angle = TURN * speed * time
    revolutions = speed * time
    grown = 0.01 * np.exp(np.minimum(draw.uniform(0.5, 3.0) * (revolutions - BEGIN), 50.0))
    grown /= (1.0 + grown**4) ** 0.25
    turned, phase, direction = ratio * angle, draw.uniform(0.0, TURN), draw.uniform(0.0, TURN)
    size, noise = draw.uniform(0.15, 0.6), float(draw.choice([0.0, 0.01, 0.03]))
    bow = draw.uniform(0.0, 0.06) * np.exp(1j * (angle + draw.uniform(0.0, TURN)))
    offset = draw.uniform(0.0, 0.2) * np.exp(1j * draw.uniform(0.0, TURN))
    if inclined and kind not in {"creeping", "rolling", "impacts"}:
        offset, size = 0.6, 0.5 * size
        offset = offset * (1.0 - np.exp(-time / 0.1))
    pace = np.exp(1j * (turned + phase))
    if kind == "still":
        part = 0.0 * pace
    elif kind in {"plane", "plane once a turn"}:
        part = _ellipse(np.abs(turned), size, size * draw.choice([0.0, 0.1, -0.1, 0.2, -0.2]), phase, direction)
    elif kind == "arc":
        beat = np.cos(turned + phase) + 0.4 * np.cos(1.13 * turned)
        inclined, offset = True, 0.0
        part = 0.95 * np.exp(1j * np.radians(draw.uniform(20.0, 75.0)) * grown * beat / 1.4)
        part = part * (1.0 - np.exp(-time / 0.1))
        grown = 1.0
    elif kind.startswith("ellipse"):
        part = _ellipse(np.abs(turned), size, np.sign(ratio) * size * draw.uniform(0.35, 0.9), phase, direction)
    elif kind == "two whirls":
        other = -np.sign(ratio) * draw.uniform(0.2, 0.7)
        other = other if abs(abs(other) - abs(ratio)) > 0.15 else -0.3 * ratio
        part = size * pace + size * draw.uniform(0.3, 0.6) * np.exp(1j * (other * angle + direction))
    elif kind == "irregular":  # on the low side it is not told from a swing: only in vertical holes
        lines = draw.normal(0.0, 0.6, 24)
        part = size * np.exp(1j * (angle[:, None] * lines + draw.uniform(0.0, TURN, 24))).sum(axis=1) / np.sqrt(24)
    elif kind == "synchronous":
        ratio, offset = 1.0, offset * 0.5
        part, bow = max(size, 0.35) * np.exp(1j * (angle + phase)), bow * 0.3
    elif kind in {"creeping", "rolling"}:
        part, offset, bow = pace, 0.0, 0.2 * bow * (grown < 0.9)
    elif kind == "impacts":
        hops = np.abs(np.sin(0.5 * TURN * draw.uniform(1.3, 4.0) * revolutions + phase))  # arcs between two strikes
        part, offset, bow = pace * (1.0 - draw.uniform(0.12, 0.5) * hops), 0.0, 0.0 * bow
    else:
        part = size * pace
    centre = grown * part + offset + bow
    centre = centre / np.maximum(np.abs(centre), 1.0)
    force = (np.abs(centre) > 0.985).astype(float) if draw.random() < 0.5 else None
    mark = MarkInfo("mark", 1.0, "wall", roll * clearance, clearance, inclined=inclined)
    return Drawn(kind, mark, time, angle, centre, noise, ratio, force, seed)


def judged(kind: str, seed: int) -> tuple[bool, bool, MotionState | None, float]:
    """Whether the onset is right, the lasting state is right, that state, and the error of the ratio."""
    record = drawn(kind, seed)
    summary = record.analysed().summary()
    found = summary.lasting_motion
    onset = (summary.onset is None) == (kind in CALM)
    error = abs((summary.whirl_ratio or 0.0) - record.ratio) / max(abs(record.ratio), 0.2)
    return onset, found in EXPECTED[kind], found, error


def table(seeds: range, kinds: list[str] | None = None) -> None:
    """Print what is found of each kind."""
    for kind in kinds or EXPECTED:
        rows = [judged(kind, seed) for seed in seeds]
        found = Counter("none" if state is None else state.value for _, _, state, _ in rows)
        near = sum(error < 0.02 for *_, error in rows)
        print(f"{kind:18s} onset {sum(r[0] for r in rows)}/{len(rows)}  state {sum(r[1] for r in rows)}/{len(rows)}  "
              f"ratio {near}  {dict(found.most_common())}", flush=True)  # fmt: skip


if __name__ == "__main__":
    table(range(int(sys.argv[1]), int(sys.argv[2])), sys.argv[3:] or None)
