# SPDX-License-Identifier: Apache-2.0
"""Run-ups of an unbalanced string through its critical speed; in a third of them a whirl grows after it.

The string is a Jeffcott rotor: its free vibration, which dies with its own damping, is part of the solution.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin_evidence.detection.frozen.measured import Turning, draw_errors, draw_marks, measured
from drill_twin_evidence.detection.frozen.motions import Motion, assembled, ellipse, exponential, resting, within
from drill_twin_evidence.detection.frozen.truth import FIXED, FORWARD, SYNCHRONOUS, FrozenRecord, Truth


def jeffcott(time: Array, angle: Array, speed: Array, critical: float, damping: float) -> ComplexArray:
    """Path of a rotor of unit eccentricity from its steady state at the first speed, shape (T,).

    z'' + 2 D w z' + w^2 z = (speed^2 - i speed') exp(i angle), with critical speed w [rad/s] and damping ratio D; the
    two first-order parts are integrated exactly, the force by trapezia.
    """
    step, force = time[1] - time[0], (speed**2 - 1j * np.gradient(speed, time)) * np.exp(1j * angle)
    root = critical * np.sqrt(1.0 - damping**2)
    poles = (complex(-damping * critical, root), complex(-damping * critical, -root))
    parts = []
    for pole in poles:
        kept, first = np.exp(pole * step), force[0] / (1j * speed[0] - pole)
        driven = 0.5 * step * (force[1:] + kept * force[:-1])
        parts.append(np.concatenate(([first], lfilter([1.0], [1.0, -kept], driven, zi=[kept * first])[0])))
    found: ComplexArray = (parts[0] - parts[1]) / (poles[0] - poles[1])
    return found


def run_up(number: int, draw: np.random.Generator) -> FrozenRecord:
    """A run-up with a small or a large peak, or with a small one after which a whirl grows."""
    case, marks = number % 3, draw_marks(draw)
    critical, sense = math.tau * draw.uniform(0.8, 4.0), float(draw.choice([-1.0, 1.0]))
    start, end = draw.uniform(0.35, 0.6) * critical, draw.uniform(1.4, 2.2) * critical
    damping = float(np.exp(draw.uniform(math.log(0.01), math.log(0.1))))
    before, ramp, after = draw.uniform(10.0, 16.0), draw.uniform(15.0, 60.0), 50.0 if case == 2 else 20.0
    begins = math.tau * before / start
    lasts = math.tau * ramp / (0.5 * (start + end))
    ends = begins + lasts + math.tau * after / end
    step = 1.0 / (draw.uniform(20.0, 60.0) * end / math.tau)
    fine = 8
    time: Array = np.arange(int(ends / step) * fine, dtype=float) * (step / fine)
    speed = start + (end - start) * np.clip((time - begins) / lasts, 0.0, 1.0)
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * step / fine))
    path = jeffcott(time, angle, speed, critical, damping)[::fine]
    path = path if sense > 0.0 else path.conj()
    samples = Turning(time[::fine], sense * angle[::fine], sense * speed[::fine], sense)
    peak = float(np.abs(path).max())
    height = draw.uniform(0.5, 0.85) if case == 1 else draw.uniform(0.02, 0.15)
    shape = (1.0 - draw.uniform(0.0, 0.4) * np.linspace(0.0, 1.0, len(marks))).astype(complex)
    ratio = critical / end
    grown = Motion(FORWARD, ratio, ellipse(samples, ratio, 1.0, draw), float(draw.uniform(0.3, 0.7)), shape)
    growth = np.exp(draw.uniform(math.log(0.2), math.log(1.5)))
    quiet = before + ramp + 10.0
    size = exponential(samples, grown.level, growth, quiet) if case == 2 else np.full(path.size, 1e-9)
    part, truth = assembled(samples, [grown], size)
    passing = np.interp(truth.time, samples.time, np.abs(path)) / peak
    truth = _passed(truth, passing, height * np.abs(shape), case)
    centre = within(part + height / peak * path[:, None] * shape + resting(samples, draw, 0.1, 0.01, len(marks)))
    kind = ("small peak", "large peak", "small peak, then whirl")[case]
    name = f"{number}: {kind} {height:.2f}, damping {damping:.3f}, ramp of {ramp:.0f} rev"
    return measured("b", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw, sees_spin=True)


def _passed(truth: Truth, passing: Array, height: Array, case: int) -> Truth:
    """Truth with the passage of the critical speed; `passing`: response over its largest, shape (s,).

    Between its half-power points, where the power is half of its largest, a large response is synchronous whirl.
    Nothing is said from a tenth of the response on until they, and of what is left after them until a whirl grows.
    """
    top, names = int(np.argmax(passing)), []
    for i, share in enumerate(passing.tolist()):
        inside = share > math.sqrt(0.5)
        if case == 1:
            names.append(SYNCHRONOUS if inside else FIXED if i < top and share < 0.3 else "")
        elif i < top:
            names.append(FIXED if share < 0.3 else "")
        else:
            names.append(FORWARD if case == 2 and truth.amplitude[i].max() > 0.02 else "")
    moving = passing[:, None] * height if case == 1 else np.zeros_like(truth.amplitude)
    amplitude = truth.amplitude if case == 2 else np.zeros_like(truth.amplitude)
    states = tuple(names)
    return replace(
        truth, amplitude=amplitude, moving=moving, motion=states, marks=(states,) * height.size,
        ratio=truth.ratio if case == 2 else None, synchronous=case == 1,
    )  # fmt: skip
