# SPDX-License-Identifier: Apache-2.0
"""Conservation of energy, momentum and angular momentum."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.audit.energy import energy, gauss_positions
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model import element_unknowns
from drill_twin.physics.model.mesh import Rod
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, LATERAL, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import LINE_MASS, quiet_scene
from drill_twin_evidence.verify.signals import AT_REST

GRAVITY = 9.81
BALANCE = "balance"


@case(forms=FORMS)
def energy_of_a_swing(form: str) -> Iterator[Row]:
    """Energy over thirty seconds of undamped free motion of the hanging rod after a large initial velocity; free bit.

    The midpoint rule conserves the quadratic energy of the lateral formulation to round-off, and that of the spatial
    formulation without drift, to the square of the step.
    """
    tolerance = 1e-12 if form == LATERAL else 1e-4
    yield Row("largest change of energy, of what was put in [-]", "kinetic + bending + stretch + m g z is kept",
              "Hairer, Lubich and Wanner 2006, ch. IX", 0.0, swing(form, elements=16, tolerance=1e-6),
              tolerance, relative=False)  # fmt: skip


def swing(form: str, *, elements: int, tolerance: float) -> float:
    """Largest change of energy in thirty seconds of undamped free motion, over the initial kinetic energy [-]."""
    effects = {"gravity": {"magnitude": GRAVITY}, "lateral_kick": {"velocity": 0.5, "shape": "half_wave"}}
    twin = Twin(quiet_scene(effects, bit_end="free", elements=elements, step=2e-3, form=form, tolerance=tolerance))
    total = _lateral_energy if form == LATERAL else _spatial_energy
    start = total(twin)
    put_in = energy(twin.rod, *twin.unknowns).kinetic
    worst = 0.0
    for _ in range(300):
        twin.advance(AT_REST, 0.1)
        worst = max(worst, abs(total(twin) - start) / put_in)
    return worst


def _spatial_energy(twin: Twin) -> float:
    u, v = twin.unknowns
    height = gauss_positions(twin.rod, u)[:, 2].reshape(-1, 2)
    weight = 0.5 * twin.rod.length[:, None] * LINE_MASS * GRAVITY
    return energy(twin.rod, u, v).total + float(np.sum(weight * height))


def _lateral_energy(twin: Twin) -> float:
    """Kinetic and bending energy, and the work against gravity (T / 2) r'^2 with T the weight below [J]."""
    rod, (u, v) = twin.rod, twin.unknowns
    q, dq = (np.stack([rows[:-1, 0:2], rows[:-1, 3:5], rows[1:, 0:2], rows[1:, 3:5]], 1) for rows in (u, v))
    first, second = (np.einsum("epi,eic->epc", rod.shape[:, :, order], q) for order in (1, 2))
    tension = LINE_MASS * GRAVITY * twin.model.places.reshape(-1, 2)
    weight = 0.5 * rod.length[:, None]
    held = rod.bending[:, None] * np.sum(second**2, -1) + tension * np.sum(first**2, -1)
    return float(0.5 * np.einsum("eic,eij,ejc->", dq, rod.mass, dq) + 0.5 * np.sum(weight * held))


@case(forms=FORMS)
def angular_momentum_of_a_conical_swing(form: str) -> Iterator[Row]:
    """Angular momentum about the axis of the hole of a conical pendulum motion; the only moment is that of the drive.

    Conserved to round-off and the tolerance of Newton's method.
    """
    before, after = _conical_swing({}, form)
    yield Row("angular momentum after half a second [kg m2/s]", "that at the start and the drive's impulse", BALANCE,
              before, after, 1e-6)  # fmt: skip


@case()
def angular_momentum_of_a_damped_conical_swing() -> Iterator[Row]:
    """Angular momentum of the swing of `angular_momentum_of_a_conical_swing` with material damping: an internal moment.

    The damping of bending acts on the motion of the axis and, with a couple, on the spin; both together do not change
    the angular momentum. To the square of the step.
    """
    before, after = _conical_swing({"internal_damping": {"bending_time": 0.02}}, "spatial")
    yield Row("angular momentum after half a second [kg m2/s]", "that at the start and the drive's impulse", BALANCE,
              before, after, 1e-4)  # fmt: skip


def angular_momentum(rod: Rod, u: Array, v: Array) -> float:
    """Angular momentum about the hole's axis [kg m2/s], spin included."""
    q, dq = element_unknowns(u), element_unknowns(v)
    orbital = np.einsum("ei,eij,ej->", q[..., 0], rod.mass, dq[..., 1])
    orbital -= np.einsum("ei,eij,ej->", q[..., 1], rod.mass, dq[..., 0])
    return float(orbital + np.sum(rod.spin_mass * 0.5 * (v[:-1, 6] + v[1:, 6])))


def _conical_swing(effects: dict[str, dict[str, float]], form: str) -> tuple[float, float]:
    """Angular momentum at the start with the impulse of the drive, and that after half a second [kg m2/s]."""
    twin = Twin(quiet_scene(effects, bit_end="free", step=1e-3, frame_rate=1000.0, form=form))
    u, v = twin.unknowns
    arc = 1.0 - twin.rod.arc / twin.rod.arc[-1]
    shape, slope = arc**2, -2.0 * arc / twin.rod.arc[-1]
    u[:, 0], u[:, 3] = 0.05 * shape, 0.05 * slope
    v[:, 1], v[:, 4] = 0.03 * shape, 0.03 * slope
    before = angular_momentum(twin.rod, u, v)
    impulse = sum(twin.advance(AT_REST, 1e-3).rig.top_drive_torque * 1e-3 for _ in range(500))
    return before + impulse, angular_momentum(twin.rod, u, v)


@case()
def momentum_along_the_hole() -> Iterator[Row]:
    """Balance of axial momentum of the hanging rod under a pulsating load on the bit, gravity and hookload.

    The balance holds in every step, to the tolerance of Newton's method.
    """
    twin = Twin(quiet_scene({"gravity": {"magnitude": GRAVITY}}, step=1e-4, frame_rate=2000.0))
    weight = LINE_MASS * GRAVITY * float(twin.rod.arc[-1])
    impulse, before, largest = 0.0, 0.0, 0.0
    for k in range(400):
        load = 20.0 * float(np.sin(0.05 * (k + 1)) ** 2)
        frame = twin.advance(Command(weight_on_bit=load, rotation=0.0), 5e-4)
        impulse += 5e-4 * (0.5 * (before + load) + frame.rig.hookload - weight)
        before = load
        largest = max(largest, abs(_axial_momentum(twin)))
    yield Row("error of the momentum, of its largest [-]", "integral of load, hookload and weight", BALANCE, 0.0,
              (_axial_momentum(twin) - impulse) / largest, 1e-6, relative=False)  # fmt: skip


def _axial_momentum(twin: Twin) -> float:
    """Axial momentum of the rod [kg m/s]; cubic elements represent a uniform velocity exactly."""
    _, v = twin.unknowns
    dq = np.stack([v[:-1, 2], v[:-1, 5], v[1:, 2], v[1:, 5]], 1)
    one: Array = np.array([1.0, 0.0, 1.0, 0.0])
    return float(np.einsum("i,eij,ej->", one, twin.rod.mass, dq))


@case()
def angular_momentum_of_twist() -> Iterator[Row]:
    """Angular momentum of the straight rod under an oscillating rotation of the top: the angular impulse of the drive.

    Linear, so conserved to round-off.
    """
    twin = Twin(quiet_scene({}, step=1e-4, frame_rate=2000.0))
    impulse, largest = 0.0, 0.0
    for k in range(200):
        speed = 3.0 * float(np.sin(0.1 * (k + 1)))
        impulse += twin.advance(Command(weight_on_bit=0.0, rotation=speed), 5e-4).rig.top_drive_torque * 5e-4
        largest = max(largest, abs(angular_momentum(twin.rod, *twin.unknowns)))
    yield Row("error of the angular momentum, of its largest [-]", "integral of the drive's torque", BALANCE, 0.0,
              (angular_momentum(twin.rod, *twin.unknowns) - impulse) / largest, 1e-6, relative=False)  # fmt: skip
