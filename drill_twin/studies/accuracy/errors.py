# SPDX-License-Identifier: Apache-2.0
"""Errors of a run against the converged run: path before the onset, statistics after it.

After the onset the motion is chaotic, so that only statistics converge. Their uncertainty is the spread of replicas of
the converged run, which differ by a small perturbation of the initial velocity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.studies.accuracy.motion_run import Motion

SETTLED = 0.5
"""Share of the run after which statistics are taken."""


@dataclass(frozen=True)
class MotionErrors:
    """Differences from the converged run, all dimensionless; None where there is nothing to compare."""

    path: float | None
    """Largest distance of a mark's centre line from the converged one before the onset, over its largest radius."""
    onset: float | None
    """Relative error of the onset time."""
    frequency: float | None
    """Relative error of the whirl frequency."""
    radius: float
    """Error of the mean orbit radius, over the clearance."""
    contact: float
    """Error of the share of nodes at the wall."""
    hookload: float | None = None
    """Relative error of the mean hookload after half of the run."""
    torque: float | None = None
    """Relative error of the mean torque of the top drive after half of the run."""
    stick_slip: float | None = None
    """Relative error of the period of stick-slip."""

    @property
    def controlled(self) -> float:
        """The error that `accuracy` controls: the larger of path and onset error."""
        known = [value for value in (self.path, self.onset) if value is not None]
        return max(known) if known else 0.0


def statistics(motion: Motion) -> tuple[float, float]:
    """Mean orbit radius over the clearance and share of nodes at the wall, of the settled part [-]."""
    late = motion.time > SETTLED * motion.time[-1]
    radius = np.hypot(motion.centre[late, :, 0], motion.centre[late, :, 1]) / motion.clearance
    return float(radius.mean()), float(motion.contact[late].mean())


def compare(motion: Motion, reference: Motion) -> MotionErrors:
    """Errors of a run of the same scene with the same frames."""
    radius, contact = statistics(motion)
    true_radius, true_contact = statistics(reference)
    return MotionErrors(
        path=path_error(motion, reference),
        onset=_relative(motion.onset, reference.onset),
        frequency=_relative(motion.frequency, reference.frequency),
        radius=abs(radius - true_radius),
        contact=abs(contact - true_contact),
        hookload=_relative(*(_late_mean(one, one.hookload) for one in (motion, reference))),
        torque=_relative(*(_late_mean(one, one.torque) for one in (motion, reference))),
        stick_slip=_relative(motion.stick_slip_period, reference.stick_slip_period),
    )


def errors_before(motion: Motion, reference: Motion) -> tuple[float, float]:
    """Errors of path and onset time [-], of a run that may have ended before the converged one or after it."""
    end = min(float(motion.time[-1]), float(reference.time[-1]))
    path = path_error(motion.until(end), reference.until(end)) or 0.0
    return path, _relative(motion.onset, reference.onset) or 0.0


def _late_mean(motion: Motion, values: Array) -> float:
    """Mean of the settled part; nan where it is zero, as the torque without friction."""
    return float(values[motion.time > SETTLED * motion.time[-1]].mean()) or np.nan


def path_error(motion: Motion, reference: Motion) -> float | None:
    """Largest distance between two paths before the onset, over the largest radius there [-]; None without marks."""
    end = reference.onset if np.isfinite(reference.onset) else np.inf
    early = reference.time <= end
    if not early.any() or reference.centre.shape[1] == 0:
        return None
    path, true = (run.centre[early, :, 0] + 1j * run.centre[early, :, 1] for run in (motion, reference))
    return largest_distance(path, true)


def largest_distance(path: ComplexArray, true: ComplexArray) -> float:
    """Largest distance between paths x + i y, shape (T, m), over the largest deflection of the true ones [-]."""
    largest = float(np.abs(true).max()) if true.size else 0.0
    return float(np.abs(path - true).max()) / largest if largest > 0.0 else 0.0


def spread(replicas: Sequence[Motion], reference: Motion) -> MotionErrors:
    """Root mean square of the errors of replicas of the converged run: smaller errors cannot be resolved."""
    found: dict[str, list[float]] = {}
    for replica in replicas:
        for name, error in asdict(compare(replica, reference)).items():
            if error is not None:
                found.setdefault(name, []).append(error)
    rms = {name: float(np.sqrt(np.mean(np.square(errors)))) for name, errors in found.items()}
    return MotionErrors(**{"path": None, "onset": None, "frequency": None, "radius": 0.0, "contact": 0.0, **rms})


def _relative(value: float, true: float) -> float | None:
    if np.isnan(true):
        return None if np.isnan(value) else 1.0
    return 1.0 if np.isnan(value) else abs(value - true) / abs(true)
