# SPDX-License-Identifier: Apache-2.0
"""The energy ledger: work done on the string by each effect, recorded inside the compiled step.

Each effect's contribution to load, section resultants or end loads is the difference that its call makes, times the
velocity that it does work on (`drill_twin.dynamics.audit.step_audit`).
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import RESIDUAL
from drill_twin.physics.model.mesh import SPIN, Rod
from drill_twin.physics.model.section import COUPLE, MX, MY, MZ, RESULTANTS, TORQUE
from drill_twin.physics.model.strain import Point, Strain

ACCOUNTS = ("weight_on_bit", "top_drive", "top_clamp", "newton")
WEIGHT_ON_BIT, TOP_DRIVE, TOP_CLAMP, NEWTON, FIRST_EFFECT = range(5)
"""Numbers of the accounts; the accounts of the effects follow."""
ROWS, MIN_COLUMNS = 10, 14
WORK, LOST, POWER, HEAT, LOAD, SECTION, ENDS, TOP_ROW, START, NOW = range(ROWS)
"""Rows of `EnergyLedger.entries`.

By account: the work done on the string since the start and the part of the work that an effect reports as heat [J],
then both in the current step [W]. Load (4 columns), resultants (7) and end loads (2 times 7) before the next effect;
velocity of the top after the step by the midpoint rule alone (7); stored energy at the start (5, see `STORED`); and the
row `NOW`. All in one array, since each further array would cost seconds of compiling, and because checkpoints hold it.
"""
OMEGA, SAMPLE, BEGUN, LARGEST, RESIDUE, AT_NODES = range(6)
"""Columns of the row `NOW`: the material's angular velocity about the tangent [rad/s], samples of stretch taken so far,
1 once the start is known, largest energy in motion so far [J], residual so far [J]; power of
the loads on the nodes before the next effect [W]."""
STORED = 5
"""Parts of the stored energy: kinetic, bending, stretch, torsion, wall."""
AXIAL_VELOCITY, LENGTH, STRETCH_WEIGHTS, NODE_VELOCITY = 0, 1, 2, 5
"""First rows of `EnergyLedger.gauss`."""


class EnergyLedger(NamedTuple):
    """The energy ledger of one twin."""

    entries: Array
    """Rows of `WORK` and the next, shape (10, accounts or 14)."""
    gauss: Array
    """By Gauss point, shape (6, 2 n): velocity along the hole, in the lateral form only [m/s]; length of the element
    [m]; weights of the three samples of stretch in the element [m]; by node such a velocity."""
    constrained: Array
    """Unknowns that keep their constraint in the audit, shape (2, 7): none, or the bit along the hole."""


def make_energy_ledger(effects: int, rod: Rod, *, bit_held: bool) -> EnergyLedger:
    """An empty ledger for a number of effects; `bit_held` where the bit is constrained along the hole."""
    constrained = np.zeros((2, 7))
    constrained[0, 2] = 1.0 if bit_held else 0.0
    known = np.repeat([rod.length, *rod.samples.T], 2, axis=1)
    gauss = np.stack([0.0 * known[0], *known, 0.0 * known[0]])
    return EnergyLedger(np.zeros((ROWS, max(FIRST_EFFECT + effects, MIN_COLUMNS))), gauss, constrained)


@kernel
def start_load(entries: Array, load: Array) -> None:
    """Set the load at a Gauss point that the next effect adds to."""
    for c in range(4):
        entries[LOAD, c] = load[c]


@kernel
def record_load(entries: Array, gauss: Array, account: int, here: Point, load: Array) -> None:
    """Record what an effect has added to the load at a Gauss point; a couple turns the material about the tangent."""
    along = here.vz + gauss[AXIAL_VELOCITY, here.place]
    power = (load[0] - entries[LOAD, 0]) * here.vx + (load[1] - entries[LOAD, 1]) * here.vy
    power += (load[2] - entries[LOAD, 2]) * along + (load[3] - entries[LOAD, 3]) * entries[NOW, OMEGA]
    entries[POWER, account] += 0.5 * gauss[LENGTH, here.place] * power
    start_load(entries, load)


@kernel
def record_side_friction(
    entries: Array, gauss: Array, account: int, here: Point, along: float, found: tuple[float, ...]
) -> None:
    """Record friction on a string that follows the hole, at a speed along it [m/s]: a force and a couple."""
    power = found[1] * along + found[2] * here.spin_rate
    entries[POWER, account] += 0.5 * gauss[LENGTH, here.place] * power


@kernel
def record_heat(entries: Array, gauss: Array, account: int, here: Point, power: float) -> None:
    """Record the power that an effect turns into heat at a Gauss point [W/m]."""
    entries[HEAT, account] += 0.5 * gauss[LENGTH, here.place] * power


@kernel
def start_section(entries: Array, strain: Strain, out: Array) -> None:
    """Set the angular velocity of a section and the resultants that the next effect adds to."""
    entries[NOW, OMEGA] = strain.omega
    for k in range(RESULTANTS):
        entries[SECTION, k] = out[k]


@kernel
def record_section(entries: Array, gauss: Array, account: int, s: Strain, out: Array) -> None:
    """Record what an effect has added to the resultants: moments work on P q_dot = ring + omega p, and so on."""
    power = (out[MX] - entries[SECTION, MX]) * (s.ring_x + s.omega * s.px)
    power += (out[MY] - entries[SECTION, MY]) * (s.ring_y + s.omega * s.py)
    power += (out[MZ] - entries[SECTION, MZ]) * (s.ring_z + s.omega * s.pz)
    power += (out[TORQUE] - entries[SECTION, TORQUE]) * s.tau_rate - (out[COUPLE] - entries[SECTION, COUPLE]) * s.omega
    entries[POWER, account] -= 0.5 * gauss[LENGTH, s.place] * power
    start_section(entries, s, out)


@kernel
def record_axial_damping(entries: Array, gauss: Array, account: int, element: int, force: float, rate: float) -> None:
    """Record a viscous axial force at one of the three samples of an element: both ends, then the inner one."""
    weight = gauss[STRETCH_WEIGHTS + int(entries[NOW, SAMPLE] % 3.0), 2 * element]
    entries[POWER, account] -= weight * force * rate


@kernel
def next_sample(entries: Array) -> None:
    """Advance to the next sample of stretch."""
    entries[NOW, SAMPLE] += 1.0


@kernel
def node_power(gauss: Array, v: Array, nodes: Array) -> float:
    """Power that the loads on the nodes take from the string [W]; in the lateral form also by its axial velocity."""
    power = 0.0
    for i in range(nodes.shape[0]):
        power += nodes[i, 2, RESIDUAL] * gauss[NODE_VELOCITY, i]
        for c in range(7):
            power += nodes[i, c, RESIDUAL] * v[i, c]
    return power


@kernel
def start_nodes(entries: Array, gauss: Array, v: Array, nodes: Array) -> None:
    """Set the power at the nodes that the next effect adds to."""
    entries[NOW, AT_NODES] = node_power(gauss, v, nodes)


@kernel
def record_nodes(entries: Array, gauss: Array, account: int, v: Array, nodes: Array) -> None:
    """Record what an effect has added to the loads on the nodes."""
    power = node_power(gauss, v, nodes)
    entries[POWER, account] -= power - entries[NOW, AT_NODES]
    entries[NOW, AT_NODES] = power


@kernel
def record_ends(entries: Array, account: int, turning: int, v: Array, ends: Array) -> None:
    """Record what an effect has added to the forces at bit and top; torques go to the account `turning`."""
    last = v.shape[0] - 1
    for end in range(2):
        row = 0 if end == 0 else last
        for c in range(7):
            power = (ends[end, c, RESIDUAL] - entries[ENDS, 7 * end + c]) * v[row, c]
            entries[POWER, turning if c == SPIN else account] -= power
            entries[ENDS, 7 * end + c] = ends[end, c, RESIDUAL]
