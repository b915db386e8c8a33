# SPDX-License-Identifier: Apache-2.0
"""Findings from the surface channels of a rig, without positions of marks: stick-slip, gaps, spikes, block weight."""

from __future__ import annotations

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
from drill_twin.whirl import AnalysisError, Peak, two_sided_spectrum
from drill_twin.whirl.motion.stick_slip_index import REST, TIME_BASE

CHANNELS = {
    "bit_force": "weight", "top_drive_speed": "rotation", "top_drive_torque": "torque", "hookload": "hookload",
    "bit_speed": "bit speed",
}  # fmt: skip
"""Channels that are looked at, and their short names."""
GAP = 1.5
"""Samples that are more than this many usual intervals apart enclose a gap; a line of a figure is broken there."""
SPIKE_WINDOW, FEWEST = 0.5, 7
"""Window of the running median from which a spike departs [s], and its fewest samples."""
EVEN = 0.1
"""Largest change of the speed of the top drive over a window that counts, over its mean."""
SLOWEST = 0.1
"""Lowest frequency of a swing, and of oscillations of the bit's speed [Hz]."""
STRONG, REGULAR = 0.5, 0.5
"""Swing of the torque over its mean, and share of one line in it, from which stick-slip is likely; chosen."""
THIN, BENCH = 93.0, 100.0
"""Torsional impedance of drill pipe of 3 1/2 in, 13.3 lbf/ft [N m s], and largest swing of the torque of a bench [N m].

The bit swings by no more than the torque over the impedance: 2 THIN speed is the least swing that stops it in a well.
"""
SPARSE = 1.0
"""Longest interval of samples that show a swing of stick-slip, of 2 to 10 s [s]."""


def surface(bag: Recording, kept: Mapping[str, Array]) -> dict[str, Any] | None:
    """Quantities of the channels of `without_spikes`; None for a recording with marks, or without states of the rig.

    Keys: `rate_hz`, samples in a second; `channels`, by name of the channel `gaps` (pairs of times [s]) and `spikes`
    (times [s] of their samples, which the others leave out); `torque_swing`, None without torque: `last_nm` and
    `largest_nm`, largest less least torque of the top drive over 20 s at a steady speed, their shares of the mean
    `last` and `largest`, and `period_s` of the last, which is the last as in stick-slip if there is one;
    `stick_slip_index_by_torque` (`index_by_torque`) of the last, None where the speed of the bit is known or the string
    is not; `spans` of stick-slip (pairs of times [s]), `unknown`, why they are not known, and `settled_s` and `applied`
    as in the summary, of the spans if there are any.
    """
    if not kept:
        return None
    time = bag.rig.time
    interval, channels = float(np.median(np.diff(time))), {}
    for name, values in kept.items():
        known = np.isfinite(getattr(bag.rig, name))
        spikes = time[known & np.isnan(values)].tolist()
        channels[CHANNELS[name]] = {"gaps": gaps(time, known, interval), "spikes": spikes}
    swing, index, torque, stuck = None, None, kept.get("top_drive_torque"), np.zeros(time.size, bool)
    unknown = "no torque is recorded" if torque is None else f"no steady rotation of the top drive for {TIME_BASE} s"
    if torque is not None and (found := _torque_swing(time, torque, kept.get("top_drive_speed"))):
        swing, speed, stuck = found
        unknown = "" if interval <= SPARSE else f"samples every {interval:.3g} s show no swing of 2 to 10 s"
        if swing["period_s"] and bag.scene_known and "bit_speed" not in kept:
            index = index_by_torque(bag.scene, swing["last_nm"], swing["period_s"], speed)
    if bag.summary.largest_stick_slip_index is not None:
        unknown, spans = "", [(one.start_s, one.end_s) for one in bag.summary.stick_slip]
        stuck = sum(((time >= start) & (time <= end) for start, end in spans), np.zeros(time.size, bool))
    stuck &= not unknown
    ends = np.flatnonzero(np.diff(stuck, prepend=False, append=False)).reshape(-1, 2)
    spans = [(float(time[first]), float(time[after - 1])) for first, after in ends.tolist()]
    return {
        "rate_hz": 1.0 / interval, "channels": channels, "torque_swing": swing, "stick_slip_index_by_torque": index,
        "unknown": unknown, "spans": spans, "settled_s": spans[0][0] if spans else settled_from(bag),
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
            values[known[find_spikes(values[known], window=window)]] = math.nan
            found[name] = values
    return found


def gaps(time: Array, known: Array, interval: float) -> list[tuple[float, float]]:
    """Times [s] between which samples are missing, where samples at the usual `interval` [s] are `known` or not."""
    at = np.concatenate((time[:1] - interval, time[known], time[-1:] + interval))
    return [(float(at[k]), float(at[k + 1])) for k in np.flatnonzero(np.diff(at) > GAP * interval)]


def _torque_swing(time: Array, torque: Array, speed: Array | None) -> tuple[dict[str, Any], float, Mask] | None:
    """Swing over the windows of 20 s in which the top drive turns steadily, its speed in the last [rad/s], and `stuck`.

    All windows, and no speed (NaN), where that is not recorded; `stuck`, shape (T,), has the samples of stick-slip.
    """
    swings, strong, stuck = [], [], np.zeros(time.size, bool)
    for end in np.arange(time[0] + TIME_BASE, time[-1] + 1.0):
        window = slice(*np.searchsorted(time, (end - TIME_BASE, end)).tolist())
        values = torque[window][np.isfinite(torque[window])]
        turn = math.nan if speed is None else _steady(speed[window])
        if values.size >= FEWEST and (speed is None or turn):
            swings.append((float(np.ptp(values)), float(values.mean()), window, turn))
            size, mean, *_ = swings[-1]
            if size >= STRONG * abs(mean) and not BENCH <= size < 2.0 * THIN * turn:
                line = highest_line(time[window], torque[window])
                if line and 4.0 * line.radius >= REGULAR * size:  # a sine swings by four times its line
                    strong.append(swings[-1])
                    stuck[window] = True
    if not swings:
        return None
    size, mean, window, turn = (strong or swings)[-1]
    largest = max(swings, key=lambda one: one[0])
    peak = highest_line(time[window], torque[window])
    return {
        "last_nm": size, "largest_nm": largest[0], "last": size / abs(mean), "largest": largest[0] / abs(largest[1]),
        "period_s": 1.0 / peak.frequency if peak else None,
    }, turn, stuck  # fmt: skip


def highest_line(time: Array, values: Array) -> Peak | None:
    """Highest line from `SLOWEST` on in the spectrum of a channel; None where there is none, or too short a record."""
    try:
        return two_sided_spectrum(time, values.astype(complex)).peak(SLOWEST, math.inf)
    except AnalysisError:
        return None


def _steady(speed: Array) -> float:
    """Mean speed of a window [rad/s]; 0 where it rests or changes."""
    known = speed[np.isfinite(speed)]
    if known.size < FEWEST or abs(known.mean()) < REST:
        return 0.0
    first, last = np.array_split(known, 2)
    even = abs(first.mean() - last.mean()) < EVEN * abs(known.mean())
    return float(abs(known.mean())) if even else 0.0


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
