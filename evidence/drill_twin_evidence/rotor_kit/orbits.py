# SPDX-License-Identifier: Apache-2.0
"""Measured vectors as orbits in time for the analyzer: `python -m drill_twin_evidence.rotor_kit.orbits RECORDS.csv`.

The signal of a probe is A cos(W t - phase) with A and phase of the record (lag), its line at twice the rotation, and
noise at the level of repeats. Precession is read twice: from the vectors, and by drill_twin's analyzer.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

import drill_twin as dt
from drill_twin_evidence.rotor_kit import records
from drill_twin_evidence.rotor_kit.elements import Complex, Real
from drill_twin_evidence.rotor_kit.fit import loaded
from drill_twin_evidence.rotor_kit.rig import Rigs
from drill_twin_evidence.rotor_kit.runup import ACCELERATION, RADIANS, START, reduced, roots, simulated

RATE = 800.0  # [samples/s] 48 a revolution: a sixteenth of the record's 12.8 kHz
SECONDS = 8.0  # of a record, stated
NOISE = 0.05  # [um] standard deviation of a sample; repeats' vectors scatter by 0.01 to 0.05 um
CLEARANCE = 250e-6  # [m] gap of a probe on such a shaft; chosen, the record does not state one
MICRO = 1e-6
RUN_UP_END = 2600.0 * RADIANS  # [rad/s] past the first critical and its beats
RUN_UP_UNBALANCE = np.array([20.0, 8.0])  # [g mm] half of the kit's residual: the rotor stays clear of its guard
RUN_UP_CLEARANCE = 1e-3  # [m] half of a probe's range of 2 mm


def signal(vector: complex, angle: Real) -> Real:
    """Return the displacement [um] of a vector (lag) over the angle of the shaft [rad]."""
    wave: Real = np.abs(vector) * np.cos(angle - np.angle(vector))
    return wave


def backward_share(x: Complex, y: Complex) -> Real:
    """Return the backward over the forward circle of orbits from vectors (lag) of probes at right angles.

    With lag, x = a exp(i W t) conjugated: forward is (x - i y) / 2 and backward (x + i y) / 2 (Lee and Lee 1997).
    """
    share: Real = np.abs(x + 1j * np.asarray(y)) / np.abs(x - 1j * np.asarray(y))
    return share


def orbit(x: complex, y: complex, rpm: float, rng: np.random.Generator, *, twice: float = 0.0) -> tuple[Real, Real]:
    """Return times [s] and positions [m], shape (T, 2), of a record that is synthesised from its vectors."""
    time = np.arange(int(RATE * SECONDS)) / RATE
    angle = rpm * np.pi / 30 * time
    noise = NOISE * rng.standard_normal((len(time), 2))
    second = twice * np.cos(2 * angle)[:, None]
    return time, MICRO * (np.stack([signal(x, angle), signal(y, angle)], axis=1) + second + noise)


def analysed(time: Real, position: Real, rotation: Real | float) -> dt.Whirl:
    """Return what the analyzer finds; the rotation [rad/s] is counter-clockwise, from probe x to probe y."""
    return dt.analyze(time, position[:, 0], position[:, 1], rotation, clearance=CLEARANCE)


def with_whirl(position: Real, time: Real, *, ratio: float, radius: float, rpm: float, start: float) -> Real:
    """Return positions [m] with a self-excited whirl of this ratio to the rotation that grows from start [s] on."""
    grown = radius * np.clip((time - start) / 1.0, 0.0, 1.0)
    angle = ratio * rpm * np.pi / 30 * time
    whirling: Real = position + grown[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return whirling


def run_up(rigs: Rigs, at: int, unbalance: Real, rng: np.random.Generator) -> tuple[Real, Real, Real] | None:
    """Return times [s], positions at disc 2 [m] and rotation [rad/s] of rig `at` in a run-up; None where unstable.

    Unbalances are of disc 1 and disc 2 [g mm]; sensors are at right angles, with the noise of a record.
    """
    rotors = rigs.rotors(2)
    damping, gyroscopic, stiffness, force, shapes = reduced(rotors, at, rigs.disc_places())
    matrices = (damping, gyroscopic, stiffness)
    if roots(matrices, RUN_UP_END).real.max() >= 0:
        return None
    modal = (force[:, 0] - 1j * force[:, 1]) @ (unbalance * 1e-6 + 0j)
    signals = []
    for axis in (0, 1):
        _, _, shown, step = simulated(
            matrices, modal, shapes[1, axis], start=START, end=RUN_UP_END, acceleration=ACCELERATION
        )
        signals.append(shown)
    stride = max(1, round(1 / (RATE * step)))
    time: Real = (step * np.arange(1.0, len(signals[0]) + 1.0))[::stride]
    position = np.stack(signals, axis=1)[::stride]
    noisy = position + MICRO * NOISE * rng.standard_normal(position.shape)
    return time, noisy, START + ACCELERATION * time


def run_ups(z: Real, rng: np.random.Generator) -> list[tuple[float, str]]:
    """Return largest radius over clearance and the criterion of the onset ("" where none) of run-ups of draws."""
    rigs, found = Rigs.of(z[:, :-2]), []
    for at in range(len(z)):
        run = run_up(rigs, at, RUN_UP_UNBALANCE, rng)
        if run is not None:
            time, position, rotation = run
            seen = dt.analyze(time, position[:, 0], position[:, 1], rotation, clearance=RUN_UP_CLEARANCE)
            largest = float(np.hypot(*position.T).max()) / RUN_UP_CLEARANCE
            found.append((largest, "" if seen.onset is None else seen.onset.criterion))
    return found


def main() -> int:
    """Print what the analyzer says of every labelled record at both pairs of probes, and of simulated run-ups."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path)
    parser.add_argument("fit", type=Path)
    parser.add_argument("--run-ups", type=int, default=40)
    given = parser.parse_args()
    data, rng = records.read(given.records), np.random.default_rng(0)
    for pair, (first, second) in (("p1", (0, 1)), ("p2", (2, 3))):
        states: Counter[str] = Counter()
        onsets, agreed, shares = 0, 0, backward_share(data.vectors[:, first], data.vectors[:, second])
        for row in range(len(data.condition)):
            x, y = data.vectors[row, first], data.vectors[row, second]
            time, position = orbit(x, y, data.rpm[row], rng)
            found = analysed(time, position, data.rpm[row] * np.pi / 30)
            onsets += found.onset is not None
            agreed += (np.nanmedian(found.precession) > 0) == (shares[row] < 1)
            states.update({str(line["state"]) for line in found.motion})
        print(
            f"{pair}: {len(shares)} records, forward by their vectors {int((shares < 1).sum())}, "
            f"the analyzer agrees in {agreed}, "
            f"backward over forward {shares.min():.2f} to {shares.max():.2f}; onsets {onsets}, states {dict(states)}"
        )
    runs = run_ups(loaded(given.fit)[1][: given.run_ups], rng)
    kinds = Counter(criterion.split(" over ")[0] or "none" for _, criterion in runs)
    print(f"run-ups to {RUN_UP_END / RADIANS:.0f} rpm: {len(runs)}, onsets by criterion {dict(kinds)}")
    for largest, criterion in runs:
        if criterion.startswith("asynchronous"):
            print(f"  largest radius {largest:.2f} of the clearance: {criterion}")
    return 0


if __name__ == "__main__":
    raise SystemExit(records.told(main))
