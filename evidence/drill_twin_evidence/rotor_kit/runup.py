# SPDX-License-Identifier: Apache-2.0
"""The run-up at a constant acceleration, in time: motion at p1x, revolution by revolution.

The rotor's lowest modes at rest carry gyroscopic moments, damping and cross stiffness in full; an unbalance that is
sped up pulls with the square of the speed and with the acceleration (Genta 2005, section 2.9).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from scipy.linalg import eigh
from scipy.signal import find_peaks

from drill_twin_evidence.rotor_kit.elements import Complex, Real, Rotors
from drill_twin_evidence.rotor_kit.forecast import Forecast
from drill_twin_evidence.rotor_kit.posterior import Measured
from drill_twin_evidence.rotor_kit.rig import RUNOUT_SPEED, Rigs

RADIANS = np.pi / 30  # [rad/s] of 1 rpm
START, END = 1037.0 * RADIANS, 5005.0 * RADIANS  # [rad/s] stated
ACCELERATION = 229.0 * RADIANS  # [rad/s2] stated
MODES = 6  # three in each plane; steady vectors at 1,005 rpm are within 2 % of all modes
LARGEST_STEP = 2e-4  # [s] 160 a period of the first critical; half of it moves a vector by 0.4 % of the largest
STABLE = 1.5  # step times the fastest root: Runge-Kutta of order four is stable to 2.6 in every stable direction
REVOLUTIONS = 4  # over which a vector once per revolution is averaged; chosen, the record's own filter is not known
PROMINENCE = 0.05  # of the largest amplitude: what counts as a maximum; chosen
GRID = np.arange(1050.0, 5000.0, 25.0)  # [rpm]
COLUMNS = ("rpm", "amp_um", "amp_low", "amp_high")


def reduced(rotors: Rotors, at: int, probes: Real) -> tuple[Real, Real, Real, Real, Real]:
    """Return damping, gyroscopic and stiffness matrix, force shapes and probe shapes of rotor `at` in its modes.

    Shapes: three of (modes, modes), (modes, 2 axes, discs), (2 places, 2 axes, modes).
    """
    inertia, damping, gyroscopic, stiffness = (matrix[at] for matrix in rotors.matrices)
    _, modes = eigh((stiffness + stiffness.T) / 2, inertia, subset_by_index=[0, MODES - 1])
    half = len(modes) // 2
    at_disc, at_probe = rotors.shapes(rotors.discs.places)[at], rotors.shapes(probes)[at]
    force = np.stack([at_disc @ modes[:half], at_disc @ modes[half:]]).transpose(2, 0, 1)
    seen = np.stack([at_probe @ modes[:half], at_probe @ modes[half:]], axis=1)
    turned = (modes.T @ matrix @ modes for matrix in (damping, gyroscopic, stiffness))
    damped, spun, stiff = turned
    return damped, spun, stiff, force, seen


@njit(cache=True, error_model="numpy")
def _push(
    y: Real,
    time: float,
    law: tuple[float, float, Complex],
    matrices: tuple[Real, Real, Real],
    out: Real,
) -> None:
    """Write the derivative of modal positions and velocities y at a time into out."""
    start, acceleration, force = law
    damping, gyroscopic, stiffness = matrices
    count = len(y) // 2
    speed = start + acceleration * time
    angle = start * time + acceleration * time * time / 2
    turn = (speed * speed - 1j * acceleration) * np.exp(1j * angle)
    for i in range(count):
        out[i] = y[count + i]
        pull = (force[i] * turn).real
        for j in range(count):
            pull -= stiffness[i, j] * y[j] + (damping[i, j] + speed * gyroscopic[i, j]) * y[count + j]
        out[count + i] = pull


@njit(cache=True, error_model="numpy")
def vectors_of_revolutions(
    y: Real,
    law: tuple[float, float, Complex],
    matrices: tuple[Real, Real, Real],
    seen: Real,
    until: float,
    step: float,
    found: Complex,
    speeds: Real,
    signal: Real,
) -> tuple[int, int]:
    """Run from modal state y; fill vectors once per revolution (lag), their speeds, and the signal at every step.

    Returns the count of revolutions and of steps; arrays that are too short end the run.
    """
    start, acceleration, _ = law
    count = len(y) // 2
    one, two, three = np.empty(2 * count), np.empty(2 * count), np.empty(2 * count)
    four, trial = np.empty(2 * count), np.empty(2 * count)
    turns, time, steps = 0, 0.0, 0
    total, length = 0j, 0
    while time < until and turns < len(found) and steps < len(signal):
        _push(y, time, law, matrices, one)
        for i in range(2 * count):
            trial[i] = y[i] + step / 2 * one[i]
        _push(trial, time + step / 2, law, matrices, two)
        for i in range(2 * count):
            trial[i] = y[i] + step / 2 * two[i]
        _push(trial, time + step / 2, law, matrices, three)
        for i in range(2 * count):
            trial[i] = y[i] + step * three[i]
        _push(trial, time + step, law, matrices, four)
        for i in range(2 * count):
            y[i] += step / 6 * (one[i] + 2 * two[i] + 2 * three[i] + four[i])
        time += step
        shown = 0.0
        for i in range(count):
            shown += seen[i] * y[i]
        signal[steps] = shown
        steps += 1
        angle = start * time + acceleration * time * time / 2
        total += shown * np.exp(1j * angle)
        length += 1
        if angle >= 2 * np.pi * (turns + 1):
            found[turns] = 2 * total / length
            speeds[turns] = start + acceleration * time
            turns += 1
            total, length = 0j, 0
    return turns, steps


def roots(matrices: tuple[Real, Real, Real], speed: float) -> Complex:
    """Return the characteristic roots at a speed [rad/s]."""
    damping, gyroscopic, stiffness = matrices
    size = len(damping)
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -(damping + speed * gyroscopic)]])
    return np.asarray(np.linalg.eigvals(state), complex)


def steady(matrices: tuple[Real, Real, Real], force: Complex, speed: float) -> Complex:
    """Return the modal positions of steady response at a speed, to be multiplied by exp(i angle)."""
    damping, gyroscopic, stiffness = matrices
    dynamic = stiffness - speed**2 * np.eye(len(force)) + 1j * speed * (damping + speed * gyroscopic)
    return np.asarray(np.linalg.solve(dynamic, speed**2 * force), complex)


def simulated(
    matrices: tuple[Real, Real, Real], force: Complex, seen: Real, *, start: float, end: float, acceleration: float
) -> tuple[Real, Complex, Real, float]:
    """Return speeds [rad/s], vectors a revolution, and the signal with its step [s], from steady motion at start."""
    step = min(LARGEST_STEP, STABLE / np.abs(roots(matrices, end)).max())
    until = (end - start) / acceleration
    at_start = steady(matrices, force, start)
    y = np.concatenate([at_start.real, (1j * start * at_start).real])
    revolutions = int((start * until + acceleration * until**2 / 2) / (2 * np.pi)) + 2
    found, speeds = np.zeros(revolutions, complex), np.zeros(revolutions)
    signal = np.zeros(int(until / step) + 2)
    damping, gyroscopic, stiffness = (np.ascontiguousarray(one) for one in matrices)
    turns, steps = vectors_of_revolutions(
        y,
        (start, acceleration, force),
        (damping, gyroscopic, stiffness),
        np.ascontiguousarray(seen),
        until,
        step,
        found,
        speeds,
        signal,
    )
    return speeds[:turns], found[:turns], signal[:steps], step


def of_draw(rigs: Rigs, rotors: Rotors, at: int, unbalance: Complex) -> tuple[tuple[Real, Real, Real], Complex, Real]:
    """Return modal matrices, modal force and p1x in modes [um per m times gain] of one rig with unbalances [kg m].

    The unbalance is turned by the rig's common angle, so that vectors have the phase of the record.
    """
    *matrices, force, shapes = reduced(rotors, at, rigs.probe_places())
    angle = np.deg2rad(rigs["angle"][at])
    lag = np.conj(unbalance * np.exp(1j * angle))
    modal = (force[:, 0] - 1j * force[:, 1]) @ lag
    turn = np.deg2rad(rigs["probe_angle_p1x"][at])
    gain = rigs["gain"][at] * rigs["gain_p1x"][at]
    seen = 1e6 * gain * (np.cos(turn) * shapes[0, 0] + np.sin(turn) * shapes[0, 1])
    damping, gyroscopic, stiffness = matrices
    return (damping, gyroscopic, stiffness), modal, seen


def maxima(rpm: Real, height: Real) -> list[tuple[float, float]]:
    """Return speed and height of the first two maxima."""
    peaks, _ = find_peaks(height, prominence=PROMINENCE * height.max())
    return [(float(rpm[i]), float(height[i])) for i in peaks[:2]]


def run_up(z: Real, measured: Measured, rng: np.random.Generator) -> tuple[dict[str, Any], list[list[float]]]:
    """Return the summary of the run-up and its curve with bands, from draws of the posterior (n, unknowns)."""
    rigs = Rigs.of(z[:, :-2])
    rotors = rigs.rotors(2)
    forecast = Forecast.of(z, measured, rng)
    model = rigs.sensitivities([1005.0 * RADIANS])[0]
    right = (forecast.sensitivity[0] / model)[:, 0].mean(axis=1)
    rest = measured.base[0] - (forecast.sensitivity[0] @ forecast.residual[..., None])[:, 0, 0]
    moved = forecast.scatter[:, 0] * (rng.standard_normal(len(z)) + 1j * rng.standard_normal(len(z))) / np.sqrt(2)
    curves, firsts, beats, unstable = [], [], [], 0
    for at in range(len(z)):
        matrices, force, seen = of_draw(rigs, rotors, at, forecast.residual[at] * 1e-6)
        if roots(matrices, END).real.max() >= 0:  # small motion does not die out at the end of the run-up
            unstable += 1
            continue
        slow = np.conj(seen @ steady(matrices, force, RUNOUT_SPEED)) * rigs["runout_share"][at]
        speeds, found, _, _ = simulated(matrices, force, seen, start=START, end=END, acceleration=ACCELERATION)
        vectors = right[at] * (found - slow) + rest[at] + moved[at]
        smooth = np.convolve(vectors, np.full(REVOLUTIONS, 1 / REVOLUTIONS), "valid")
        rpm = np.convolve(speeds, np.full(REVOLUTIONS, 1 / REVOLUTIONS), "valid") / RADIANS
        height = np.abs(smooth)
        curves.append(np.interp(GRID, rpm, height))
        firsts.append(maxima(rpm, height))
        beats.append(_beat(rpm, height))
    bands = np.quantile(np.array(curves), [0.5, 0.05, 0.95], axis=0)
    curve = [[float(v), *(float(b) for b in band)] for v, band in zip(GRID, bands.T, strict=True)]
    first = _of([one[0][0] for one in firsts if one])
    summary = {
        "assumed": "the rig as in BASE: which unbalance it ran with is not known; heights are those of the vector once "
        "per revolution minus run-out, as the record at 1,005 rpm has it, and motion is linear in the unbalance",
        "draws": len(curves),
        "draws_left_out_as_unstable_below_5005_rpm": unstable,
        "bands": "5, 50, 95 %",
        "first_maximum_rpm": first,
        "width_of_its_band_percent": round(100 * (first[2] - first[0]) / first[1], 1),
        "highest_rpm": _of([float(GRID[one.argmax()]) for one in curves]),
        "highest_um": _of([float(one.max()) for one in curves]),
        "first_maximum_um": _of([one[0][1] for one in firsts if one]),
        "part_of_draws_with_a_second_maximum": round(float(np.mean([len(one) > 1 for one in firsts])), 3),
        "second_maximum_rpm": _of([one[1][0] for one in firsts if len(one) > 1]),
        "second_maximum_um": _of([one[1][1] for one in firsts if len(one) > 1]),
        "first_beat_after_it_rpm": _of([one for one in beats if one]),
    }
    return summary, curve


def _beat(rpm: Real, height: Real) -> float | None:
    """Return the speed between the highest maximum and the next one [rpm]: the first beat, if there is one."""
    peaks, _ = find_peaks(height, prominence=0.02 * height.max())
    top = int(height.argmax())
    after = [i for i in peaks if i > top]
    return float(rpm[after[0]] - rpm[top]) if after else None


def _of(values: list[float]) -> list[float]:
    """Return the 5, 50 and 95 % quantile."""
    return [float(f"{q:.4g}") for q in np.quantile(values, [0.05, 0.5, 0.95])] if values else []
