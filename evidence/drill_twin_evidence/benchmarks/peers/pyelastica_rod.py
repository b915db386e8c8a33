# SPDX-License-Identifier: Apache-2.0
"""PyElastica 1.0: a Cosserat rod with shear, position Verlet.

Set-up. Time step below the shear cut-off r/c_s, which does not depend on the elements. PyElastica has no inside of a
cylinder, no clamp turned by a law and no ramped end load: those are written here, the wall as one compiled kernel.
A rod clamped by its first node and first frame bends only from the middle of its first element on, so it is one element
too short (an error of first order in frequency, 2/n). It is lengthened by L/(n - 1) with the clamps half an element
inside; the weight of the two half elements beyond them is taken off. Friction acts on the spin through the frames; its
slope at rest is bounded, so that a step does not reverse the slip.
"""

from __future__ import annotations

import numpy as np
from elastica.boundary_conditions import ConstraintBase, GeneralConstraint
from elastica.dissipation import AnalyticalLinearDamper
from elastica.external_forces import NoForces
from elastica.modules import BaseSystemCollection, Constraints, Damping, Forcing
from elastica.rod.cosserat_rod import CosseratRod
from elastica.timestepper.symplectic_steppers import PositionVerlet
from numba import njit

from drill_twin_evidence.benchmarks.peers.rod import Rod, rod_of, wall_force
from drill_twin_evidence.benchmarks.peers.task import Array, Motion, Recorder, Task

LARGEST = 0.9
"""Default step over the shear cut-off."""


class Collection(BaseSystemCollection, Constraints, Damping, Forcing):  # type: ignore[misc]
    """System that the rod is put into."""


class TurnedClamp(ConstraintBase):  # type: ignore[misc]
    """The uppermost node and frame: held, and turned about z."""

    def __init__(self, position: Array, rod: Rod, **others: object) -> None:
        super().__init__(**others)
        self.position, self.law = position, rod.rotation

    def constrain_values(self, system: CosseratRod, time: float) -> None:  # noqa: ARG002  as the base has it
        """The place; the frame follows from its rate."""
        system.position_collection[:, -1] = self.position

    def constrain_rates(self, system: CosseratRod, time: float) -> None:
        """At rest but for the spin; the rod's third director is z."""
        system.velocity_collection[:, -1] = 0.0
        system.omega_collection[0, -1] = 0.0
        system.omega_collection[1, -1] = 0.0
        system.omega_collection[2, -1] = self.law(float(time))


class Loads(NoForces):  # type: ignore[misc]
    """Weight, end load and wall."""

    def __init__(self, rod: Rod, step: float) -> None:
        super().__init__()
        self.rod, self.law = rod, np.zeros(8) if rod.law is None else rod.law.copy()
        # friction may stop the slip within a step, not reverse it; the spin's inertia is that of the whole section
        self.law[7] = 0.5 / step / (1.0 / rod.line_mass + rod.radius**2 / (2.0 * rod.density * rod.second_moment))

    def apply_forces(self, system: CosseratRod, time: float = 0.0) -> None:
        """Add them to the node's forces and, for friction, to the element's couples."""
        loads(
            self.rod.weight_on_bit(float(time)), self.rod.gravity, self.rod.law is not None, self.law, system.mass,
            system.rest_lengths, system.position_collection, system.velocity_collection, system.omega_collection,
            system.external_forces, system.external_torques,
        )  # fmt: skip


@njit(cache=True, error_model="numpy")
def loads(
    push: float, gravity: float, wall: bool, law: Array, mass: Array, lengths: Array, place: Array, velocity: Array,
    omega: Array, force: Array, torque: Array,
) -> None:  # fmt: skip
    """The end nodes carry half an element that lies beyond the clamp: it has no weight."""
    last = mass.size - 1
    force[2, 0] += push
    for i in range(1, last):
        force[2, i] -= gravity * mass[i]
        if wall:
            spin = 0.5 * (omega[2, i - 1] + omega[2, i])
            length = 0.5 * (lengths[i - 1] + lengths[i])
            fx, fy, fz, couple = wall_force(
                law, place[0, i], place[1, i], velocity[0, i], velocity[1, i], velocity[2, i], spin
            )
            force[0, i] += length * fx
            force[1, i] += length * fy
            force[2, i] += length * fz
            torque[2, i - 1] += 0.5 * length * couple
            torque[2, i] += 0.5 * length * couple


def largest_step(rod: Rod) -> float:
    """The shear cut-off r / c_s [s], with PyElastica's own shear factor 27/28 (4/3 of it in older releases)."""
    return rod.radius / float(np.sqrt(27.0 / 28.0 * rod.shear_modulus / rod.density))


def run(task: Task) -> Motion:
    """Run a task; the step defaults to 0.9 of the cut-off. Option `plain`: clamps as they come."""
    rod = rod_of(task)
    n = task.elements
    cell, beyond = rod.staggered(n, bool(task.options.get("plain")))
    simulator = Collection()
    shape = CosseratRod.straight_rod(
        n, np.array([0.0, 0.0, -rod.length - beyond]), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]),
        n * cell, rod.radius, rod.density, youngs_modulus=rod.youngs_modulus, shear_modulus=rod.shear_modulus,
    )  # fmt: skip
    heights = shape.position_collection[2] + rod.length
    kick, slope = rod.kick_at(heights)
    shape.position_collection[2] += rod.hung(heights)[0]
    shape.velocity_collection[0] = kick
    shape.omega_collection[1] = 0.5 * (slope[1:] + slope[:-1])  # the frames turn with the tangent: no shear
    simulator.append(shape)
    period = rod.duration / rod.frames
    steps = int(np.ceil(period / (task.step or LARGEST * largest_step(rod)) - 1e-9))
    step = period / steps
    simulator.constrain(shape).using(TurnedClamp, shape.position_collection[:, -1].copy(), rod)
    simulator.constrain(shape).using(
        GeneralConstraint, constrained_position_idx=(0,), constrained_director_idx=(0,),
        translational_constraint_selector=np.array([True, True, False]),
        rotational_constraint_selector=np.array([True, True, False]),
    )  # fmt: skip
    simulator.add_forcing_to(shape).using(Loads, rod, step)
    if rod.drag:
        simulator.dampen(shape).using(
            AnalyticalLinearDamper, translational_damping_constant=rod.drag * cell, rotational_damping_constant=0.0,
            time_step=np.float64(step),
        )  # fmt: skip
    simulator.finalize()
    stepper = PositionVerlet()
    start = float(shape.position_collection[2, 0])
    now = stepper.step(simulator, 0.0, 1e-12)  # compiles
    recorder = Recorder(task.limit)
    for frame in range(1, rod.frames + 1):
        now = (frame - 1) * period
        for _ in range(steps):
            now = stepper.step(simulator, now, step)
        recorder.steps += steps
        place = shape.position_collection
        reach = float(np.hypot(place[0], place[1]).max())
        if not recorder.take(frame * period, place[:2, n // 2], float(place[2, 0]) - start, reach):
            break
    return recorder.motion()
