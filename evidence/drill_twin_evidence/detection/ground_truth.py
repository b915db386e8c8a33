# SPDX-License-Identifier: Apache-2.0
"""Ground truth of a simulated run, from its full state: onset of whirl and motion states.

It uses quantities that no camera measures (every node, velocities, wall forces) and non-causal windows. The states have
the names of the paper's Fig. 7; the numbers define the states in `docs/analyzer.md`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin_evidence.detection.runs import Run

WHIRL_THRESHOLD = 0.05
"""Whirl: least radius of the asynchronous part over the clearance [-]."""
MIN_WHIRL = 1.0
"""Whirl: least duration above the threshold [rev]."""
TURN_WINDOW, MIN_TURN = 28.0, math.radians(30.0)
"""Whirl: window [rev], and least angle by which it turns within it [rad]."""
MAX_GAP = 0.5
"""Shorter gaps below the threshold do not end a whirl [rev]."""
SYNCHRONOUS_WINDOW = 12.0
"""The synchronous part is the Hann-weighted mean over these past revolutions (at the start: over the first ones) in the
frame that rotates with the string [rev]."""
WINDOW = 1.0
"""Half the window in which a state is evaluated [rev]."""
CONTACT, COHERENCE, UNEVENNESS, PLANAR, LOBE, ROLLING = 0.5, 0.85, 0.3, 0.7, 0.3, 0.5
"""Share of time in contact; regularity of angle and radius; planarity; second lobe; slip over r_o Omega."""
TOUCHING, AWAY = 0.95, 0.9
"""In contact: least radius of the centre line over the clearance; away from the wall: largest [-]."""
MIN_ROTATION = 0.05
"""No state is assigned below this rotation [rev/s]."""
STATES_PER_TURN = 8
"""States per revolution."""
IRREGULAR_WINDOW = 3.0
"""Irregular: half the window in which most of the motion must be irregular [rev]; growth, decay and changes of state
are irregular for a shorter time."""


def revolutions_of(time: Array, speed: Array) -> Array:
    """Revolutions since the first sample [rev], non-decreasing, of a speed [rad/s]; shapes (T,)."""
    steps = 0.5 * np.abs(speed[1:] + speed[:-1]) * np.diff(time)
    return np.concatenate(([0.0], np.cumsum(steps))) / math.tau


def asynchronous(centre: ComplexArray, spin: Array, revolutions: Array) -> ComplexArray:
    """Centre line without its part synchronous with the spin [m]; all shapes (T, k), `revolutions` (T,)."""
    seen = centre * np.exp(-1j * spin)
    rest = np.empty_like(centre)
    first = np.searchsorted(revolutions, revolutions - SYNCHRONOUS_WINDOW, side="right")
    settled = min(int(np.searchsorted(revolutions, SYNCHRONOUS_WINDOW)), revolutions.size - 1)
    for i, start in enumerate(first.tolist()):
        past = slice(0, max(i, settled) + 1) if revolutions[i] < SYNCHRONOUS_WINDOW else slice(start, i + 1)
        weight = np.sin(math.pi * (revolutions[past] - revolutions[past.stop - 1]) / SYNCHRONOUS_WINDOW) ** 2
        part = (weight[:, None] * seen[past]).sum(axis=0) / max(float(weight.sum()), 1e-300)
        rest[i] = centre[i] - part * np.exp(1j * spin[i])
    return rest


def whirls(radius: Array, revolutions: Array) -> Mask:
    """Mask of the samples that whirl: radius over the clearance above the threshold for at least `MIN_WHIRL` [rev]."""
    above = radius > WHIRL_THRESHOLD
    result = np.zeros(above.size, bool)
    for start, end in _intervals(above):
        if revolutions[end] - revolutions[start] >= MIN_WHIRL:
            result[start : end + 1] = True
    for start, end in _intervals(~result):
        if start > 0 and end < result.size - 1 and revolutions[end] - revolutions[start] < MAX_GAP:
            result[start : end + 1] = True
    return result


def onset(time: Array, whirl: ComplexArray, angle: Array) -> float | None:
    """First time [s] from which a whirl over the clearance is above the threshold for a revolution; None if never.

    Whirl that does not turn is a static deflection: within `TURN_WINDOW` revolutions it must have turned by `MIN_TURN`,
    relative to the hole and to the string. `angle` is that of the rotation [rad]; all shapes (T,).
    """
    revolutions = np.abs(angle) / math.tau
    for start, end in _intervals(np.abs(whirl) > WHIRL_THRESHOLD):
        if revolutions[end] - revolutions[start] >= MIN_WHIRL:
            stop = min(end, int(np.searchsorted(revolutions, revolutions[start] + TURN_WINDOW)))
            way = np.unwrap(np.angle(whirl[start : stop + 1]))
            if min(np.ptp(way), np.ptp(way - angle[start : stop + 1])) > MIN_TURN:
                return float(time[start])
    return None


def _intervals(flag: Mask) -> list[tuple[int, int]]:
    """First and last index of each interval of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False])).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True, eq=False)
class Truth:
    """Ground truth of a record; m marks, s times."""

    onset: float | None
    """Onset of whirl at the first mark [s]; None: no whirl."""
    mark_onset: tuple[float | None, ...]
    """Onset of whirl at each mark [s]."""
    time: Array
    """Times of the states [s], shape (s,)."""
    motion: tuple[str, ...]
    """Motion of the string at these times."""
    marks: tuple[tuple[str, ...], ...]
    """Motion of each mark at these times."""


def truth_of(run: Run) -> Truth:
    """Ground truth of a run in a vertical hole."""
    revolutions = revolutions_of(run.time, run.top_speed)
    clearance = np.array([mark.clearance for mark in run.marks])
    whirl = asynchronous(run.mark_centre, run.mark_spin, revolutions)
    radius = np.abs(whirl) / clearance
    angle = math.tau * revolutions * (-1.0 if run.top_speed[-1] < 0.0 else 1.0)
    onsets = tuple(onset(run.time, whirl[:, k] / clearance[k], angle) for k in range(clearance.size))
    known = [time for time in onsets if time is not None]
    marks = _Points(run.time, revolutions, whirl, np.abs(run.mark_centre) / clearance, run.top_speed)
    whirling = np.stack([whirls(radius[:, k], revolutions) for k in range(clearance.size)], axis=1)
    for k, began in enumerate(onsets):
        whirling[run.time < (math.inf if began is None else began), k] = False
    rolling = np.array([mark.rolling_ratio for mark in run.marks])
    at = _grid(revolutions)
    of_marks = []
    for k in range(clearance.size):
        assigned = [marks.state(i, k, bool(whirling[i, k]), float(rolling[k])) for i in at]
        of_marks.append(_smoothed([state for state, _ in assigned], [rough for _, rough in assigned]))
    string = _string(run, revolutions, whirling, rolling, at)
    return Truth(min(known, default=None), onsets, run.time[at], string, tuple(of_marks))


def _smoothed(states: Sequence[str], rough: Sequence[bool]) -> tuple[str, ...]:
    """States, `irregular` where most of the window is, then the most frequent state within half a revolution."""
    flags = np.array(rough, float)
    half = round(IRREGULAR_WINDOW * STATES_PER_TURN)
    share = _moving_sum(flags, half) / _moving_sum(np.ones_like(flags), half)
    still = {"", "rotation about a fixed axis"}
    assigned = [
        "irregular" if part > 0.5 and state not in still else state for part, state in zip(share, states, strict=True)
    ]
    half = STATES_PER_TURN // 2
    return tuple(
        state if state in still else _mode(assigned[max(i - half, 0) : i + half + 1], state)
        for i, state in enumerate(assigned)
    )


def _moving_sum(values: Array, half: int) -> Array:
    """Moving sum over a value and `half` values on each side."""
    result: Array = np.convolve(values, np.ones(2 * half + 1), mode="full")[half : half + values.size]
    return result


def _mode(states: Sequence[str], own: str) -> str:
    counts = Counter(states)
    most = max(counts.values())
    return own if counts[own] == most else next(state for state in states if counts[state] == most)


def _grid(revolutions: Array) -> list[int]:
    cells = np.floor(revolutions * STATES_PER_TURN)
    return [int(i) for i in np.flatnonzero(np.diff(cells, prepend=-1.0) > 0)]


def _string(run: Run, revolutions: Array, whirling: Mask, rolling: Array, at: list[int]) -> tuple[str, ...]:
    whirl = asynchronous(run.centre, run.spin, revolutions)
    nodes = _Points(run.time, revolutions, whirl, np.abs(run.centre) / run.clearance, run.top_speed)
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
    """Whirling shape: first proper orthogonal mode of the motion of the nodes, shape (n + 1,)."""
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


class _Points:
    """The asynchronous part of points of the centre line over time, shape (T, k)."""

    def __init__(self, time: Array, revolutions: Array, whirl: ComplexArray, radius: Array, speed: Array) -> None:
        self._time, self._revolutions, self._speed = time, revolutions, speed
        self._whirl, self._radius = whirl, radius
        self._velocity = np.gradient(whirl, time, axis=0)

    def window(self, i: int) -> slice:
        """Samples from a revolution before to a revolution after."""
        here = self._revolutions[i]
        low = int(np.searchsorted(self._revolutions, here - WINDOW))
        high = int(np.searchsorted(self._revolutions, here + WINDOW, side="right"))
        return slice(low, max(high, low + 2))

    def state(self, i: int, k: int, whirling: bool, rolling: float) -> tuple[str, bool]:
        """Motion of one point at one time, evaluated as regular, and whether it is irregular."""
        if abs(self._speed[i]) < MIN_ROTATION * math.tau:
            return "", False  # too slow to assign a state
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
        out = self._radius[window, k]
        touching = float((out > TOUCHING).mean()) > CONTACT
        slip = 1.0 - ratio / rolling if rolling else 0.0
        if touching and ratio < 0.0 and slip > -ROLLING:
            return "rolling along the wall" if slip < ROLLING else "creeping along the wall", rough
        if not touching and _strikes(out) >= 2.0 * WINDOW:
            return "striking the wall", rough
        return "forward whirl" if ratio > 0.0 else "backward whirl", rough


def _strikes(radius: Array) -> int:
    """Number of contacts of a radius over the clearance, shape (n,), each after a place away from the wall."""
    known = np.where(radius > TOUCHING, 1, np.where(radius < AWAY, -1, 0))
    known = known[known != 0]
    return int((np.diff(known) > 0).sum())
