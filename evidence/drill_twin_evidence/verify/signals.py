# SPDX-License-Identifier: Apache-2.0
"""Runs of a scene, and frequencies, rates and orders identified from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.scenes import LENGTH

AT_REST = Command(weight_on_bit=0.0, rotation=0.0)


def run_for(scene: Scene, seconds: float, *, interval: float = 0.05, rotation: float = 0.0) -> Twin:
    """Run a scene under its weight on bit and return the twin."""
    twin = Twin(scene)
    command = Command(weight_on_bit=scene.rig.weight_on_bit.value, rotation=rotation)
    for _ in range(round(seconds / interval)):
        twin.advance(command, interval)
    return twin


def free_motion(scene: Scene, seconds: float, interval: float) -> Array:
    """Lateral position x of every node over a free motion [m], shape (samples, n + 1)."""
    twin = Twin(scene)
    command = Command(weight_on_bit=scene.rig.weight_on_bit.value, rotation=0.0)
    frames = [twin.advance(command, interval) for _ in range(round(seconds / interval))]
    return np.array([frame.positions[:, 0] for frame in frames])


def squared_frequencies(motion: Array, interval: float, modes: int) -> Array:
    """omega^2 [1/s2] of the strongest modes, ascending; negative for a mode that grows as cosh.

    An undamped mode obeys x(t + T) + x(t - T) = 2 c x(t) with c = cos(omega T) or cosh(sigma T), whatever its phase.
    Projected on the strongest shapes of the motion this is a small eigenvalue problem.
    """
    _, _, shapes = np.linalg.svd(motion, full_matrices=False)
    reduced = motion @ shapes[:modes].T
    mean = 0.5 * (reduced[2:] + reduced[:-2])
    matrix = np.linalg.lstsq(reduced[1:-1], mean, rcond=None)[0]
    c = np.sort(np.real(np.linalg.eigvals(matrix)))[::-1]
    angle = np.where(np.abs(c) <= 1.0, np.arccos(np.clip(c, -1.0, 1.0)), 0.0)
    growth = np.arccosh(np.maximum(c, 1.0))
    found: Array = (angle**2 - growth**2) / interval**2
    return found


def rates(signal: NDArray[Any], interval: float, order: int = 2) -> ComplexArray:
    """Complex rates lambda [1/s] of a sum of exp(lambda t), by linear prediction (Prony's method)."""
    history = np.stack([signal[k : k - order] for k in range(order)], -1)
    combination = np.linalg.lstsq(history, signal[order:], rcond=1e-10)[0]
    found: ComplexArray = np.log(np.roots(np.append(1.0, -combination[::-1])).astype(complex)) / interval
    return found


def first_mode(arc: Array) -> tuple[Array, Array]:
    """First mode of the clamped-clamped rod and its slope, unscaled (Blevins 1979)."""
    x, ratio = 4.730040745 / LENGTH * arc, 0.9825022158
    shape = np.cosh(x) - np.cos(x) - ratio * (np.sinh(x) - np.sin(x))
    return shape, 4.730040745 / LENGTH * (np.sinh(x) + np.sin(x) - ratio * (np.cosh(x) - np.cos(x)))


def rotating_frame_response(
    scene: Scene, speed: float, seconds: float, interval: float = 0.02
) -> tuple[complex, float, float]:
    """Steady position of the first mark in the frame that rotates with the string, its scatter [m], and torque [N m].

    Means over the last second of a run whose rotation rises to `speed` within the first second.
    """
    twin = Twin(scene)
    places, torques = [], []
    for k in range(round(seconds / interval)):
        frame = twin.advance(Command(weight_on_bit=0.0, rotation=speed * min((k + 1) * interval, 1.0)), interval)
        places.append(complex(*frame.marks.centre[0, :2]) * np.exp(-1j * frame.marks.spin[0]))
        torques.append(frame.rig.top_drive_torque)
    last = slice(-round(1.0 / interval), None)
    return complex(np.mean(places[last])), float(np.std(places[last])), float(np.mean(torques[last]))


def convergence_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Order of convergence: fitted slope of log error over log size."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])
