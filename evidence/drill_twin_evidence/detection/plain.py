# SPDX-License-Identifier: Apache-2.0
"""A plain detector of whirl, as a peer of `drill_twin.whirl`: what a few lines of NumPy find.

Offset and once-per-revolution part by fading sums, power and rate from products of neighbouring bins,
conj(a_i) a_{i+1}, in which white noise has no mean; hysteresis, a revolution, 30 degrees; coherence, contact and
planarity over two revolutions. Its constants were chosen on `frozen_records(base=TUNED_ON)`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.signal import lfilter

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin_evidence.detection.frozen.score import Finding
from drill_twin_evidence.detection.frozen.truth import (
    BACKWARD,
    BENDING,
    CREEP,
    FIXED,
    FORWARD,
    IRREGULAR,
    ROLLING,
    SPIRAL,
    SWING,
    FrozenRecord,
)  # fmt: skip

TUNED_ON = 8_100_000
BINS, MEMORY, SHORT, LONG = 16, (6.0, 24.0), 0.5, 2.0
"""Bins in a revolution; memory of offset and 1x before and in whirl, windows of power and of rate [rev]."""
LEVEL, RELEASE, SWEPT, TURN = 0.05, 0.04, math.radians(30.0), 28.0
"""Onset: radius over the clearance, and of its end; angle swept, within so many revolutions."""
COHERENCE, UNEVEN, CIRCULAR, CONTACT, AT_WALL, PLANAR, LOBE, SLIP = 0.7, 0.3, 0.3, 0.5, 0.95, 0.7, 0.3, 0.5
HALF, FADE = 8, math.exp(-1.0 / (4.0 * BINS))
"""Half a revolution [bins], and memory of the share of rough time."""


def plain(record: FrozenRecord) -> Finding:
    """Findings of the plain detector."""
    time, psi, z = _binned(record)
    m = z.shape[1]
    slow = [_rest(z, psi, memory) for memory in MEMORY]
    a, found = slow[0].copy(), [_onset(slow[0][:, k], psi) for k in range(m)]
    for k, (start, _) in enumerate(found):
        if start is not None:
            a[start:, k] = slow[1][start:, k]
    pair = a[:-1].conj() * a[1:]
    product, power = _mean(np.vstack((pair, pair[-1:])), LONG), _mean(np.abs(a) ** 2, LONG).real
    step = (psi[-1] - psi[0]) / (psi.size - 1)
    ratio = np.angle(product) / step
    later = np.vstack((np.zeros((HALF, m)), a[HALF:] * a[:-HALF].conj()))
    coherence = np.abs(_mean(later, LONG)) / np.maximum(power, 1e-12)
    size = _mean(np.abs(a), LONG).real
    uneven = np.sqrt(np.maximum(power - size**2, 0.0)) / np.maximum(size, 1e-12)
    plane = np.abs(_mean(a * a, LONG)) / np.maximum(power, 1e-12)  # 1: to and fro, 0: circle
    touching = _mean((np.abs(z) > AT_WALL).astype(float), LONG).real > CONTACT
    rolling = np.array([mark.rolling_ratio for mark in record.marks])
    slip = np.abs(1.0 - ratio / np.minimum(rolling, -1e-9))
    swings = (plane > 1.0 - CIRCULAR) & ~touching
    state = np.where(ratio > 0.0, FORWARD, BACKWARD).astype(object)
    state[touching & (ratio < 0.0)] = CREEP
    state[touching & (ratio < 0.0) & (slip < SLIP)] = ROLLING
    rough = lfilter([1.0 - FADE], [1.0, -FADE], (coherence < COHERENCE) | (uneven > UNEVEN), axis=0) > 0.5
    state[rough] = IRREGULAR
    state[swings] = SWING
    radius = np.sqrt(power)
    whirls = np.array([np.arange(time.size) >= (math.inf if start is None else start) for start, _ in found]).T
    whirls &= radius > RELEASE
    state[~whirls] = FIXED
    lead = np.argmax(radius, axis=1)
    rows = np.arange(time.size)
    string = state[rows, lead]
    shape = _mean(a * a[rows, lead].conj()[:, None], LONG)
    planarity = np.abs((shape**2).sum(axis=1)) / np.maximum((np.abs(shape) ** 2).sum(axis=1), 1e-12)
    turned = (shape * np.exp(-0.5j * np.angle((shape**2).sum(axis=1)))[:, None]).real
    sides = np.sort(np.stack((turned.max(axis=1), -turned.min(axis=1))), axis=0)
    moving = whirls.any(axis=1) & (string != FIXED) & (string != SWING)
    string[moving & (sides[0] > LOBE * sides[1])] = BENDING
    string[moving & (planarity < PLANAR)] = SPIRAL
    starts = [(start, known, k) for k, (start, known) in enumerate(found) if start is not None and known is not None]
    onset, known, mark = min(starts, default=(None, None, 0))
    regular = whirls[:, mark] & ~rough[:, mark]
    own = float(np.median(ratio[regular, mark])) if regular.any() else None

    def states(of: Any) -> Any:
        return lambda at: of[np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 1)].tolist()

    return Finding(
        None if onset is None else float(time[onset]), None if known is None else float(time[known]), False, LEVEL,
        own, states(string), tuple(states(state[:, k]) for k in range(m)),
    )  # fmt: skip


def _binned(record: FrozenRecord) -> tuple[Array, Array, ComplexArray]:
    """Time [s], angle of the rotation [rad], centre line over the clearance of each bin."""
    order = np.unique(record.stamp, return_index=True)[1]
    time, speed = record.stamp[order] * 1e-9, record.top_speed[order]
    psi = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))
    z = record.position[order, :, 0] + 1j * record.position[order, :, 1]
    clearance = np.array([mark.clearance for mark in record.marks])
    if record.spin is not None and record.marks[0].on == "wall":
        z = z - np.array([mark.wall_offset for mark in record.marks]) * np.exp(1j * record.spin[order])
    z, most = z / clearance, 2.0 + (record.spin is None) * max(mark.wall_offset for mark in record.marks) / clearance
    z[np.abs(z) > most] = math.nan
    index = (np.abs(psi) / math.tau * BINS).astype(int)
    filled, first = np.unique(index, return_index=True)
    seen = np.isfinite(z)
    count = np.add.reduceat(seen, first, axis=0)
    total = np.add.reduceat(np.where(seen, z, 0.0), first, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total / count
    mid = np.add.reduceat(np.column_stack((time - time[0], psi)), first, axis=0)
    mid = mid / np.diff([*first, time.size])[:, None]
    bins = np.arange(filled[0], filled[-1] + 1)  # gaps are bridged by straight lines
    z = np.stack([np.interp(bins, filled[ok], mean[ok, k]) for k in range(z.shape[1])
                  for ok in (np.isfinite(mean[:, k]),)], axis=1)  # fmt: skip
    return time[0] + np.interp(bins, filled, mid[:, 0]), np.interp(bins, filled, mid[:, 1]), z


def _rest(z: ComplexArray, psi: Array, memory: float) -> ComplexArray:
    """Motion without offset and 1x, both fitted with a fading memory [rev]."""
    fade, turn = math.exp(-1.0 / (memory * BINS)), np.exp(1j * psi)[:, None]

    def kept(values: Any) -> Any:
        return lfilter([1.0], [1.0, -fade], values, axis=0)

    n, both, sum_z, sum_turn = kept(np.ones((psi.size, 1))), kept(turn), kept(z), kept(z * turn.conj())
    lack = np.maximum(n * n - np.abs(both) ** 2, 1e-9 * n * n)
    offset, bow = (n * sum_z - both * sum_turn) / lack, (n * sum_turn - both.conj() * sum_z) / lack
    found: ComplexArray = z - offset - bow * turn
    found[:BINS] = 0.0
    return found


def _mean(values: Any, window: float) -> Any:
    """Mean over the last `window` [rev]."""
    size = round(window * BINS)
    return lfilter(np.ones(size) / size, [1.0], values, axis=0)


def _onset(a: ComplexArray, psi: Array) -> tuple[int | None, int | None]:
    """Bins of onset and of its announcement."""
    pair = np.append(a[:-1].conj() * a[1:], 0.0)
    product = _mean(pair, SHORT)
    radius, step = np.sqrt(np.abs(product)), np.abs(np.diff(psi, append=psi[-1]))
    way = np.cumsum(np.angle(product) * (radius > 0.0))
    in_string = way - np.cumsum(np.sign(psi[-1]) * step)
    start: int | None = None
    for i, size in enumerate(radius.tolist()):
        if start is None and size > LEVEL:
            start = i
        elif start is not None and size < RELEASE:
            start = None
        if start is not None and i - start >= BINS:
            first = max(start, i - round(TURN * BINS))
            if min(np.ptp(way[first : i + 1]), np.ptp(in_string[first : i + 1])) > SWEPT:
                return max(start - round(0.5 * SHORT * BINS), 0), i
    return None, None
