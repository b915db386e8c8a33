# SPDX-License-Identifier: Apache-2.0
"""The truth of a simulated run, from its full state: when whirl began, and what motion the string was in.

It may use what no camera sees (every node, velocities, wall forces) and look ahead. The words are those of the paper's
Fig. 7; the numbers are those that define the states in `docs/analyzer.md`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray, Mask
from drill_twin.studies.detection.runs import Run

LEVEL = 0.05
"""Whirl: radius of the asynchronous part over the clearance."""
STAYS = 1.0
"""Whirl: for this long above [rev]."""
ROUND, TURNED = 28.0, math.radians(30.0)
"""Whirl: it goes round by so much [rad] within so many revolutions [rev]."""
BRIDGED = 0.5
"""Dips below that are shorter do not end a whirl [rev]."""
BOW_MEMORY = 12.0
"""The synchronous part is the mean over these past revolutions (at the start: over the first), Hann-weighted, seen from
the turning string [rev]."""
WINDOW = 1.0
"""States are judged from this long before to this long after [rev]."""
CONTACT, COHERENCE, UNEVENNESS, PLANAR, LOBE, ROLLING = 0.5, 0.85, 0.3, 0.7, 0.3, 0.5
"""Share of time in contact; regularity of angle and radius; planarity; second lobe; slip over r_o Omega."""
TOUCHING = 0.95
"""In contact: the centre line has used this share of its clearance."""
REST = 0.05
"""No state is judged below this rotation [rev/s]."""
GRID = 8
"""States in a revolution."""
LASTING = 3.0
"""Irregular: rough for most of the time from this long before to this long after; growth, decay and changes are uneven
too, but pass [rev]."""


def turned(time: Array, speed: Array) -> Array:
    """Revolutions since the first sample, never falling [rev], of a speed [rad/s]; shapes (T,)."""
    steps = 0.5 * np.abs(speed[1:] + speed[:-1]) * np.diff(time)
    return np.concatenate(([0.0], np.cumsum(steps))) / math.tau


def asynchronous(centre: ComplexArray, spin: Array, revolutions: Array) -> ComplexArray:
    """The centre line without its part synchronous with the spin [m]; all shapes (T, k), `revolutions` (T,)."""
    seen = centre * np.exp(-1j * spin)
    rest = np.empty_like(centre)
    first = np.searchsorted(revolutions, revolutions - BOW_MEMORY, side="right")
    settled = min(int(np.searchsorted(revolutions, BOW_MEMORY)), revolutions.size - 1)
    for i, start in enumerate(first.tolist()):
        past = slice(0, max(i, settled) + 1) if revolutions[i] < BOW_MEMORY else slice(start, i + 1)
        weight = np.sin(math.pi * (revolutions[past] - revolutions[past.stop - 1]) / BOW_MEMORY) ** 2
        part = (weight[:, None] * seen[past]).sum(axis=0) / max(float(weight.sum()), 1e-300)
        rest[i] = centre[i] - part * np.exp(1j * spin[i])
    return rest


def whirls(radius: Array, revolutions: Array) -> Mask:
    """Whether a radius over the clearance, shape (T,), belongs to a stretch above `LEVEL` of at least `STAYS`."""
    above = radius > LEVEL
    result = np.zeros(above.size, bool)
    for start, end in _stretches(above):
        if revolutions[end] - revolutions[start] >= STAYS:
            result[start : end + 1] = True
    for start, end in _stretches(~result):
        if start > 0 and end < result.size - 1 and revolutions[end] - revolutions[start] < BRIDGED:
            result[start : end + 1] = True
    return result


def onset(time: Array, whirl: ComplexArray, angle: Array) -> float | None:
    """First time [s] from which a whirl over the clearance stays above `LEVEL` for a revolution; None if never.

    One that does not go round is a string that leans: within `ROUND` revolutions it must have turned by `TURNED`, as
    seen from the hole and from the string. `angle` is that of the rotation [rad]; all shapes (T,).
    """
    revolutions = np.abs(angle) / math.tau
    for start, end in _stretches(np.abs(whirl) > LEVEL):
        if revolutions[end] - revolutions[start] >= STAYS:
            stop = min(end, int(np.searchsorted(revolutions, revolutions[start] + ROUND)))
            way = np.unwrap(np.angle(whirl[start : stop + 1]))
            if min(np.ptp(way), np.ptp(way - angle[start : stop + 1])) > TURNED:
                return float(time[start])
    return None


def _stretches(flag: Mask) -> list[tuple[int, int]]:
    """First and last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False])).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True, eq=False)
class Truth:
    """What a run is known to have done; m marks, s times."""

    onset: float | None
    """When the first mark began to whirl [s]."""
    mark_onset: tuple[float | None, ...]
    """When each mark did [s]."""
    time: Array
    """Times of the states [s], shape (s,)."""
    motion: tuple[str, ...]
    """Motion of the string at these times."""
    marks: tuple[tuple[str, ...], ...]
    """Motion of each mark at these times."""


def truth_of(run: Run) -> Truth:
    """The truth of a run in a vertical hole."""
    revolutions = turned(run.time, run.top_speed)
    clearance = np.array([mark.clearance for mark in run.marks])
    whirl = asynchronous(run.mark_centre, run.mark_spin, revolutions)
    radius = np.abs(whirl) / clearance
    angle = math.tau * revolutions * (-1.0 if run.top_speed[-1] < 0.0 else 1.0)
    onsets = tuple(onset(run.time, whirl[:, k] / clearance[k], angle) for k in range(clearance.size))
    known = [time for time in onsets if time is not None]
    touching = np.abs(run.mark_centre) > TOUCHING * clearance
    marks = _View(run.time, revolutions, whirl, touching, run.top_speed)
    whirling = np.stack([whirls(radius[:, k], revolutions) for k in range(clearance.size)], axis=1)
    for k, began in enumerate(onsets):
        whirling[run.time < (math.inf if began is None else began), k] = False
    rolling = np.array([mark.rolling_ratio for mark in run.marks])
    at = _grid(revolutions)
    of_marks = []
    for k in range(clearance.size):
        judged = [marks.state(i, k, bool(whirling[i, k]), float(rolling[k])) for i in at]
        of_marks.append(_smoothed([state for state, _ in judged], [rough for _, rough in judged]))
    string = _string(run, revolutions, whirling, rolling, at)
    return Truth(min(known, default=None), onsets, run.time[at], string, tuple(of_marks))


def _smoothed(states: Sequence[str], rough: Sequence[bool]) -> tuple[str, ...]:
    """The states, irregular where most of the time around is rough, each the commonest within half a revolution."""
    flags = np.array(rough, float)
    share = _around(flags, round(LASTING * GRID)) / _around(np.ones_like(flags), round(LASTING * GRID))
    still = {"", "rotation about a fixed axis"}
    judged = [
        "irregular" if part > 0.5 and state not in still else state for part, state in zip(share, states, strict=True)
    ]
    half = GRID // 2
    return tuple(
        state if state in still else _commonest(judged[max(i - half, 0) : i + half + 1], state)
        for i, state in enumerate(judged)
    )


def _around(values: Array, half: int) -> Array:
    """Sum over `half` values on each side."""
    result: Array = np.convolve(values, np.ones(2 * half + 1), mode="full")[half : half + values.size]
    return result


def _commonest(states: Sequence[str], own: str) -> str:
    counts = Counter(states)
    most = max(counts.values())
    return own if counts[own] == most else next(state for state in states if counts[state] == most)


def _grid(revolutions: Array) -> list[int]:
    cells = np.floor(revolutions * GRID)
    return [int(i) for i in np.flatnonzero(np.diff(cells, prepend=-1.0) > 0)]


def _string(run: Run, revolutions: Array, whirling: Mask, rolling: Array, at: list[int]) -> tuple[str, ...]:
    touching = np.abs(run.centre) > TOUCHING * run.clearance
    whirl = asynchronous(run.centre, run.spin, revolutions)
    nodes = _View(run.time, revolutions, whirl, touching, run.top_speed)
    length = np.gradient(run.arc)
    states, rough = [], []
    for i in at:
        motion = run.centre[nodes.window(i)]
        leader = int(np.argmax((np.abs(motion) ** 2).sum(axis=0)))
        state, uneven = nodes.state(i, leader, bool(whirling[i].any()), float(rolling.mean()))
        if state not in {"", "rotation about a fixed axis"}:
            shape = _shape(motion, length)
            if _planarity(shape, length) < PLANAR:
                state = "spiral"
            elif _second_lobe(shape) > LOBE:
                state = "second bending"
        states.append(state)
        rough.append(uneven)
    return _smoothed(states, rough)


def _shape(motion: ComplexArray, length: Array) -> ComplexArray:
    """The shape that turns: the strongest principal part of the nodes' motion, shape (n + 1,)."""
    scaled = motion * np.sqrt(length)
    _, _, parts = np.linalg.svd(scaled, full_matrices=False)
    shape: ComplexArray = parts[0] / np.sqrt(length)
    return shape


def _planarity(shape: ComplexArray, length: Array) -> float:
    return float(abs((length * shape**2).sum()) / (length * np.abs(shape) ** 2).sum())


def _second_lobe(shape: ComplexArray) -> float:
    """Largest radius on one side of the axis over that on the other, in the plane of the shape; at most 1."""
    plane = np.exp(0.5j * np.angle((shape**2).sum()))
    seen = (shape / plane).real
    sides = sorted((float(seen.max()), float(-seen.min())))
    return max(sides[0], 0.0) / sides[1]


class _View:
    """The asynchronous part of points of the centre line over time, shape (T, k)."""

    def __init__(self, time: Array, revolutions: Array, whirl: ComplexArray, contact: Mask, speed: Array) -> None:
        self._time, self._revolutions, self._speed = time, revolutions, speed
        self._whirl, self._contact = whirl, contact
        self._velocity = np.gradient(whirl, time, axis=0)

    def window(self, i: int) -> slice:
        """From a revolution before to a revolution after."""
        here = self._revolutions[i]
        low = int(np.searchsorted(self._revolutions, here - WINDOW))
        high = int(np.searchsorted(self._revolutions, here + WINDOW, side="right"))
        return slice(low, max(high, low + 2))

    def state(self, i: int, k: int, whirling: bool, rolling: float) -> tuple[str, bool]:
        """Motion of one point at one time, as if it were alone and regular, and whether it is rough."""
        if abs(self._speed[i]) < REST * math.tau:
            return "", False  # hardly turns: not judged
        if not whirling:
            return "rotation about a fixed axis", False
        window = self.window(i)
        z, v, time = self._whirl[window, k], self._velocity[window, k], self._time[window]
        pace = float((z.conj() * v).imag.sum() / (np.abs(z) ** 2).sum())
        ratio = pace / float(self._speed[window].mean())
        back = z * np.exp(-1j * pace * (time - time[0]))
        radius = np.abs(z)
        trend = np.polyval(np.polyfit(time - time[0], radius, 1), time - time[0])
        coherence = abs(back.sum()) / radius.sum()
        unevenness = float(np.sqrt(((radius - trend) ** 2).mean())) / float(radius.mean())
        rough = coherence < COHERENCE or unevenness > UNEVENNESS
        touching = float(self._contact[window, k].mean()) > CONTACT
        slip = 1.0 - ratio / rolling if rolling else 0.0
        if touching and ratio < 0.0 and abs(slip) < ROLLING:
            return "rolling along the wall", rough
        return "forward whirl" if ratio > 0.0 else "reverse whirl", rough
