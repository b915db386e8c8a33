# SPDX-License-Identifier: Apache-2.0
"""Findings from the surface channels of a rig, without positions of marks: stick-slip, gaps, spikes, block weight."""

import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.discretisation.resolution import MOST
from drill_twin.physics.model.mesh import build_rod
from drill_twin.report.quantities import applied, settled_from
from drill_twin.report.recording import Recording
from drill_twin.scene import Scene
from drill_twin.scene.set_points.tables import find_spikes
from drill_twin.whirl.motion.stick_slip_index import FULL, REST, TIME_BASE

CHANNELS = {
    "bit_force": "weight", "top_drive_speed": "rotation", "top_drive_torque": "torque", "hookload": "hookload",
    "bit_speed": "bit speed",
}  # fmt: skip
"""Channels that are looked at, and their short names."""
GAP = 1.5
"""Samples that are more than this many usual intervals apart enclose a gap; a line of a figure is broken there."""
SPIKE_WINDOW, FEWEST, BRIEF = 0.5, 7, 2
"""Window of the running median from which a spike departs [s], its fewest samples; most of a spike of the torque."""
EVEN = 0.1
"""Largest change of the speed of the top drive over a window that counts, over its mean."""
SLOWEST = 0.1
"""Lowest frequency of a swing, and of oscillations of the bit's speed [Hz]."""
STRONG, REGULAR, REGULAR_HALF, LIKE, QUICKEST, LASTS = 0.5, 0.6, 0.5, 2.0, 0.4, 5
"""Swing of the torque over its mean from which stick-slip is likely, share of a line in 40 s and in each half,
largest ratio of the amplitudes of the halves, highest frequency of the line over the rate, and least number of windows
in succession that have it; chosen."""
THIN, BENCH = 93.0, 100.0
"""Torsional impedance of drill pipe of 3 1/2 in, 13.3 lbf/ft [N m s], and largest swing of the torque of a bench [N m].

The bit swings by no more than the torque over the impedance: 2 THIN speed is the least swing that stops it in a well.
"""
SPARSE = 1.0
"""Longest interval of samples that show a swing of stick-slip, of 2 to 10 s [s]."""


def surface(bag: Recording, kept: Mapping[str, Array]) -> dict[str, Any] | None:
    """Quantities of the channels of `without_spikes`; None for a recording with marks, or without states of the rig.

    Keys: `rate_hz`, samples in a second; `channels`, by name of the channel `gaps` (pairs of times [s]) and `spikes`
    (times [s] of their samples, which the others leave out); `torque_swing`, None without torque: `largest_nm`, largest
    less least torque of the top drive over 20 s at a steady speed, its share of the mean `largest`, `period_s` of the
    largest regular swing, None without one, and `irregular`, the largest share where no swing so large is regular, or
    0; `stick_slip_index_by_torque` (`index_by_torque`), None where the speed of the bit is known or the string is not;
    `spans` of stick-slip (pairs of times [s]), `unknown`, why they are not known, `watched_s` of `duration_s`, time
    with torque at steady rotation, and `settled_s` and `applied` as in the summary, of the spans if there are any.
    """
    if not kept:
        return None
    time = bag.rig.time
    interval, channels = float(np.median(np.diff(time))), {}
    for name, values in kept.items():
        known = np.isfinite(getattr(bag.rig, name))
        spikes = time[known & np.isnan(values)].tolist()
        channels[CHANNELS[name]] = {"gaps": gaps(time, known, interval), "spikes": spikes}
    swing, index, torque, speed = None, None, kept.get("top_drive_torque"), kept.get("top_drive_speed")
    stuck = watched = np.zeros(time.size, bool)
    if torque is None:
        unknown = "no torque is recorded"
    elif interval > SPARSE:
        unknown = f"samples every {interval:.3g} s show no swing of 2 to 10 s"
    elif time[-1] - time[0] < TIME_BASE - interval:
        unknown = f"the record is shorter than {TIME_BASE} s"
    else:
        swing, index, stuck, watched = _torque_swing(bag, torque, speed)
        unknown = "" if swing else f"no steady rotation of the top drive for {TIME_BASE} s"
        if swing and not swing["largest_nm"] and not np.nanmax(np.abs(torque)):
            unknown = "the torque is zero"
        elif swing and swing["irregular"]:
            unknown = f"the torque swings by {swing['irregular']:.2f} of its mean, not regularly over {2 * TIME_BASE} s"
    if bag.summary.largest_stick_slip_index is not None:
        unknown, spans = "", [(one.start_s, one.end_s) for one in bag.summary.stick_slip]
        stuck = sum(((time >= start) & (time <= end) for start, end in spans), np.zeros(time.size, bool))
    stuck &= not unknown
    ends = np.flatnonzero(np.diff(stuck, prepend=False, append=False)).reshape(-1, 2)
    spans = [(float(time[first]), float(time[after - 1])) for first, after in ends.tolist()]
    return {
        "rate_hz": 1.0 / interval, "channels": channels, "torque_swing": swing, "stick_slip_index_by_torque": index,
        "unknown": unknown, "watched_s": float(watched.sum() * interval), "spans": spans,
        "duration_s": float(time[-1] - time[0]) + interval, "settled_s": spans[0][0] if spans else settled_from(bag),
        "applied": applied(bag, kept, stuck if spans else None),
    }  # fmt: skip


def without_spikes(bag: Recording) -> dict[str, Array]:
    """Channels of a record without marks that it has, NaN in their spikes, shape (T,); empty for any other bag."""
    rig, found = bag.rig, {}
    if bag.places or len(rig) < FEWEST:
        return {}
    window = max(FEWEST, round(SPIKE_WINDOW / float(np.median(np.diff(rig.time)))))
    for name in CHANNELS:
        values = getattr(rig, name).copy()
        if (known := np.flatnonzero(np.isfinite(values))).size:
            odd = known[find_spikes(values[known], window=window)]
            if name == "top_drive_torque":  # stick-slip at 1 Hz recurs
                at = rig.time[odd]
                near = np.searchsorted(at, at + TIME_BASE, "right") - np.searchsorted(at, at - TIME_BASE)
                odd = odd[near <= BRIEF]
            values[odd] = math.nan
            found[name] = values
    return found


def gaps(time: Array, known: Array, interval: float) -> list[tuple[float, float]]:
    """Times [s] between which samples are missing, where samples at the usual `interval` [s] are `known` or not."""
    at = np.concatenate((time[:1] - interval, time[known], time[-1:] + interval))
    return [(float(at[k]), float(at[k + 1])) for k in np.flatnonzero(np.diff(at) > GAP * interval)]


def _torque_swing(
    bag: Recording, torque: Array, speed: Array | None
) -> tuple[dict[str, Any] | None, float | None, Mask, Mask]:
    """Swing over 20 s of steady rotation, its index, the samples of stick-slip and the watched ones, shape (T,).

    All windows where no speed is recorded. A string, where the bit's speed is not known, tells the windows that stick.
    """
    time, known, swings, lines = bag.rig.time, np.isfinite(torque), [], []
    stuck, watched = np.zeros((2, time.size), bool)
    indexed = bag.scene_known and bag.summary.largest_stick_slip_index is None and speed is not None
    unit, run = functools.cache(lambda line: index_by_torque(bag.scene, 1.0, 1.0 / line, 1.0)), 0
    for end in np.arange(time[0] + TIME_BASE, time[-1] + 1.01):
        first, middle, after = np.searchsorted(time, (end - 2 * TIME_BASE, end - TIME_BASE, end)).tolist()
        values, turn = torque[middle:after][known[middle:after]], math.nan
        if values.size < FEWEST or not (speed is None or (turn := _steady(speed[middle:after]))):
            run = 0
            continue
        watched[middle:after] |= known[middle:after]
        size, mean = float(np.ptp(values)), float(values.mean())
        strong = size >= max(STRONG * abs(mean), 1e-9) and not BENCH <= size < 2.0 * THIN * turn
        swings.append((size, size / (abs(mean) or size or 1.0), strong))
        steady = time[0] <= end - 2 * TIME_BASE and (speed is None or _steady(speed[first:middle]))
        line = regular_line(time[first:after], torque[first:after]) if steady else None
        run = run + 1 if line else 0
        if line and run >= LASTS:
            index = unit(round(line, 4)) * size / turn if indexed else None
            lines.append((size, index, strong, 1.0 / line))
            stuck[first:after] |= strong and (index is None or index >= FULL)
    if not swings:
        return None, None, stuck, watched
    size, share, strong = max(swings)
    regular = max((one for one in lines if one[2] or not strong), key=lambda one: one[0], default=None)
    large = [] if any(one[2] for one in lines) else [one for one in swings if one[2]]
    return {
        "largest_nm": size, "largest": share, "period_s": regular[3] if regular else None,
        "irregular": max(large)[1] if large else 0.0,
    }, regular[1] if regular else None, stuck, watched  # fmt: skip


def regular_line(time: Array, values: Array) -> float | None:
    """Frequency of a line that carries a channel, and each half of it, with its second harmonic [Hz]; None without.

    The largest line after the trend is removed, from `SLOWEST` on, of like amplitude in both halves; a step, a pulse, a
    ramp and noise have none.
    """
    known, even = np.isfinite(values), np.linspace(time[0], time[-1], time.size)
    size = np.ptp(whole := np.interp(even, time[known], values[known]))
    whole -= whole.mean() + (ramp := np.linspace(-1.0, 1.0, even.size)) * (ramp @ whole / (ramp @ ramp))
    half, step = time.size // 2, float(even[1] - even[0])
    parts = (whole, whole[:half], whole[-half:])
    powers = [float(part @ part) for part in parts]
    if half < FEWEST or max(powers[1:]) >= LIKE**2 * min(powers[1:]) or LIKE * np.ptp(whole) < size:
        return None
    lines = np.array([2.0 * np.abs(np.fft.rfft(part, 16 * half)) ** 2 / (part.size * power)
                      for part, power in zip(parts, powers, strict=True)])  # fmt: skip
    at = int(lines[0, : int(QUICKEST * 16 * half)].argmax())
    twice = min(2 * at, 16 * half - 2 * at)  # as samples show it
    share = lines[:, at] + (lines[:, twice] if at < 0.3 * 16 * half else 0.0)
    frequency = at / (16 * half * step)
    return frequency if frequency >= SLOWEST and share[0] >= REGULAR and share[1:].min() >= REGULAR_HALF else None


def _steady(speed: Array) -> float:
    """Mean speed of a window [rad/s]; 0 where it rests or changes."""
    known = speed[np.isfinite(speed)]
    if known.size < FEWEST or abs(known.mean()) < REST:
        return 0.0
    first, last = np.array_split(known, 2)
    return float(abs(known.mean())) if abs(first.mean() - last.mean()) < EVEN * abs(known.mean()) else 0.0


def index_by_torque(scene: Scene, swing: float, period: float, speed: float) -> float:
    """Stick-slip index that a swing of the surface torque means: the swing of the bit's speed over twice its mean.

    The string twists as a chain of shafts that is free at the bit: from there up, each adds its twist and its inertia
    at this period, the body of `bit_mass` first. Friction along the string, left out, makes the index too large.

    Args:
        scene: The string.
        swing: Largest less least torque of the top drive [N m].
        period: Period of the swing [s].
        speed: Mean speed of rotation [rad/s].
    """
    rod, turn = build_rod(tubes_of(scene), MOST), math.tau / period
    body = getattr(scene.effects, "bit_mass", None)
    angle, torque = 1.0, 0.0 if body is None else -(turn**2) * body.inertia  # of the bit [rad], along the string [N m]
    for length, stiffness, inertia in zip(rod.length, rod.torsion, rod.spin_mass, strict=True):
        torque -= 0.5 * turn**2 * inertia * angle
        angle += torque * length / stiffness
        torque -= 0.5 * turn**2 * inertia * angle
    return float(swing * turn / abs(torque) / (2.0 * speed))
