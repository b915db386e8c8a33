# SPDX-License-Identifier: Apache-2.0
"""Stick-slip."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import as_python
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import bit_torque_tanh
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.contact.torsional_reference import Pipe, cycle_of, torsion
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import steel

INTERVAL = 0.02
NAVARRO = "Navarro-Lopez and Suarez 2004"
SWITCHED = f"{NAVARRO}, integrated with a switch for sticking"
EVENTS = "integrated with events (torsional_reference.py)"
REGIMES = ("stuck", "stick-slip", "steady")
EXPECTED = (
    (50.75e3, 0.0, "steady"),
    (52e3, 0.0, "stick-slip"),
    (57e3, 0.0, "stick-slip"),
    (58.25e3, 0.0, "stuck"),
    (58.25e3, 8.0, "steady"),
    (59.5e3, 8.0, "stuck"),
)
"""Weight on bit [N], speed at the start [rad/s], and what follows: from rest steady to 51.25 kN, stick-slip from 51.5
to 57.5, stuck from 57.75; from 8 rad/s steady to 58.75, stuck from 59."""
CYCLES = {
    53.018e3: (4.469, 5.440, 2.448, 0.189, 1.696, 3.167),
    55e3: (4.633, 4.828, 1.961, 0.285, 1.209, 2.656),
}
"""Period [s], peak and mean of the bit [rad/s], share of time stuck, slowest and fastest of the top [rad/s]."""


def bit_and_top_speed(weight: float, *, start: float = 0.0, seconds: float = 120.0) -> Array:
    """Speed of bit and top [rad/s] every 20 ms of a run that begins with everything turning at `start`."""
    twin = Twin(load_scene("two_mass", overrides={"wob": f"{weight} N"}))
    twin.unknowns[1][:, 6] = start
    command = Command(weight, 100.0)
    rows = (twin.advance(command, INTERVAL).rig for _ in range(round(seconds / INTERVAL)))
    return np.array([(rig.bit_speed, rig.top_drive_speed) for rig in rows])


@case()
def thresholds() -> Iterator[Row]:
    """The two-mass string within 1 % of its thresholds, on both sides; the same weight can stick from rest and rotate
    steadily from an initial speed.

    The regime is a category, hence no tolerance.
    """
    for weight, start, kind in EXPECTED:
        late = bit_and_top_speed(weight, start=start)[-1500:, 0]
        found = "stuck" if late.max() < 1e-2 else "steady" if np.ptp(late) < 0.05 * late.mean() else "stick-slip"
        yield Row(f"{kind} at {weight / 1e3:g} kN from {start:g} rad/s (stuck 0, stick-slip 1, steady 2)",
                  "two masses on a spring, torque R W (mu_c + (mu_s - mu_c) exp(-gamma w))", SWITCHED,
                  REGIMES.index(kind), REGIMES.index(found), 0.0, relative=False)  # fmt: skip


@case()
def steady_turning() -> Iterator[Row]:
    """Steady speed at 50 kN, where the torque of the drive balances drag and bit torque.

    Steady state; the tolerance covers the residual transient.
    """
    speed = 4.345
    for _ in range(60):  # Newton's method for the balance
        friction = 0.155575 * 50e3 * 0.3 * np.exp(-0.9 * speed)
        miss = 475.0 * speed + 0.155575 * 50e3 * 0.5 + friction - 6000.0
        speed -= miss / (475.0 - 0.9 * friction)
    yield Row("speed [rad/s]", "u - (c_r + c_b) w = R W (mu_c + (mu_s - mu_c) exp(-gamma w))", NAVARRO, float(speed),
              float(bit_and_top_speed(50e3)[-1, 0]), 1e-4)  # fmt: skip


@case(weight=tuple(CYCLES))
def cycle(weight: float) -> Iterator[Row]:
    """The limit cycle from rest.

    The reference is an adaptive Runge-Kutta integration of the two equations to 1e-9 with events; the twin regularises
    the friction law at zero speed, and frames are 20 ms apart.
    """
    bit, top = bit_and_top_speed(weight)[-3000:].T
    loose = np.flatnonzero((bit[:-1] < 0.05) & (bit[1:] >= 0.05))
    of_cycle = slice(loose[0], loose[-1])
    period, peak, mean, stuck, slowest, fastest = CYCLES[weight]
    for what, exact, found in (
        ("period [s]", period, float(np.diff(loose).mean()) * INTERVAL),
        ("peak speed of the bit [rad/s]", peak, float(bit.max())),
        ("mean speed of the bit [rad/s]", mean, float(bit[of_cycle].mean())),
        ("slowest speed of the top [rad/s]", slowest, float(top.min())),
        ("fastest speed of the top [rad/s]", fastest, float(top.max())),
    ):
        yield Row(what, "two masses on a spring", SWITCHED, exact, found, 5e-3)
    yield Row("share of time stuck [-]", "two masses on a spring", SWITCHED, stuck,
              float(np.mean(bit[of_cycle] < 0.01)), 5e-3, relative=False)  # fmt: skip


PIPES = (Pipe(100.0, 0.2032, 0.0714), Pipe(1100.0, 0.127, 0.1086))
"""Collars and drill pipe."""
LIGHT, HEAVY = 30e3, 120e3
"""Weights on bit [N]: buckling asks for a step of 8.6 ms under the heavy one, and leaves it to rotation and frames
under the light one."""


def well(weight: float, rpm: float, arm: float, seconds: float) -> Scene:
    """A string of 1,200 m that follows the hole but for 20 m, at the step and the mesh that `auto` chooses."""
    sections = [{"length": each.length, "outer_diameter": each.outer, "inner_diameter": each.inner} for each in PIPES]
    return Scene.model_validate({
        "name": "stick_slip_well",
        "string": {"sections": sections, "bit_end": "guided"},
        "hole": {"radius": 0.155},
        "rig": {
            "weight_on_bit": {"value": weight}, "rotation": {"value": f"{rpm} rpm"},
            "duration": seconds,
        },
        "effects": {
            "gravity": {}, "stretch": {}, "torsion": {}, "wall": {"stiffness": 1e10},
            "internal_damping": {"bending_time": 1e-3, "stretch_time": 1e-3, "torsion_time": 1e-3},
            "bit_torque_stribeck": {"radius": arm, "sliding": 0.2, "sticking": 0.4, "decay": 0.3},
        },
        "numerics": {"frame_rate": 50.0, "lateral_from": 1180.0},
    })  # fmt: skip


@case(weight=(LIGHT, HEAVY), rpm=(20.0, 30.0, 60.0, 130.0))
def cycle_in_a_well(weight: float, rpm: float) -> Iterator[Row]:
    """Limit cycle of a distributed string under two weights of the same torque, at the step that `auto` chooses.

    The reference holds a bit that sticks and changes between sticking and sliding at events; elements of 30 m.
    """
    torque, seconds = 12.444e3, 60.0
    twin, top = Twin(well(weight, rpm, torque / weight, seconds)), rpm * np.pi / 30.0
    ends: Array = np.arange(1, round(seconds / INTERVAL) + 1, dtype=float) * INTERVAL
    rows = [twin.advance(Command(weight, top * min(end / 10.0, 1.0)), INTERVAL).rig for end in ends.tolist()]
    spin, speed = np.array([(rig.bit_angle, rig.bit_speed) for rig in rows]).T
    string = torsion(PIPES, 30.0, 1e-3, lambda w: torque * (0.2 + 0.2 * np.exp(-0.3 * w)), top, 10.0)
    time, exact = string.run(seconds, 0.01)
    late = round(30.0 / INTERVAL)
    found = cycle_of(ends[late:] - 0.5 * INTERVAL, np.diff(spin)[late - 1 :] / INTERVAL)  # means: no alternation
    known = cycle_of(time[time > 30.0], exact[time > 30.0])
    yield Row("period [s]", "torsion of a string over a bit in dry friction", EVENTS, known.period, found.period, 0.01)
    yield Row("peak speed of the bit [rad/s]", "torsion of a string over a bit in dry friction", EVENTS, known.peak,
              float(speed[late:].max()), 0.01)  # fmt: skip


@case(speed=(1.0, 1.5, 2.0, 4.0), long=True)
def growth_under_the_smooth_law(speed: float) -> Iterator[Row]:
    """A heavy bit on a short pipe: small torsional motion about steady rotation grows where the torque falls
    steeply with speed.

    It grows below the speed where W T' + c = 0 and decays above it. A third of the inertia of the pipe is added to the
    bit, an approximation good to 1e-2.
    """
    weight, inertia, damping = 3e5, 400.0, 30.0
    effects = {
        "bit_torque_tanh": {},
        "bit_mass": {"inertia": inertia, "damping": damping},
        "rock_floor": {"stiffness": 1e8, "damping": 1e5},
    }
    twin = Twin(steel(effects, at="top", weight_on_bit=weight))
    law = bit_torque_tanh.Parameters(**dict(bit_torque_tanh.BitTorqueTanh()))
    torque, slope = as_python(bit_torque_tanh.torque)(law, weight, speed)
    stiffness = float(twin.rod.torsion[0])
    u, v = twin.unknowns
    u[:, 6] = twin.rod.arc * (torque + damping * speed) / stiffness
    u[-1, 6] += 0.5e-3 * speed  # the top reaches its speed during the first step
    v[:, 6] = speed + 1e-3 * (1.0 - twin.rod.arc / twin.rod.arc[-1])
    command = Command(weight, speed)
    seen = np.array([twin.advance(command, 1e-3).rig.bit_speed for _ in range(1000)]) - speed
    peaks = np.flatnonzero((seen[1:-1] > seen[:-2]) & (seen[1:-1] > seen[2:])) + 1
    found = float(np.polyfit(peaks * 1e-3, np.log(seen[peaks]), 1)[0])
    length = float(twin.rod.arc[-1])
    mass = inertia + float(twin.rod.spin_mass.sum()) / 3.0
    exact = -(slope + damping + stiffness / length * 2e-3) / (2.0 * mass)
    yield Row("growth rate [1/s]", "-(W T' + c) / (2 J)", "Real, Ritto and others 2018 for the law", float(exact),
              found, 0.01 * abs(float(exact)) + 5e-3, relative=False)  # fmt: skip
