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

# Accounts; those of the effects follow.
WEIGHT, DRIVE, CLAMP, NEWTON, FIRST_EFFECT = 0, 1, 2, 3, 4
ACCOUNTS = ("weight_on_bit", "top_drive", "top_clamp", "newton")
# Rows of EnergyLedger.entries: by account the work done on the string since the start and the part of it that an effect
# reports as heat [J], and both in the current step [W]; load (4), resultants (7) and end loads (2 times 7) before the
# next effect; velocity of the top after the step by the midpoint rule alone (7), stored energy at the start (5, see
# STORED), and the row NOW. One array: each more, passed from call to call, would cost seconds of compiling.
WORK, LOST, POWER, HEAT, LOAD, SECTION, ENDS, TOP_ROW, START, NOW = range(10)
ROWS, MIN_COLUMNS = 10, 14
# Indices into the row NOW: the material's angular velocity about the tangent [rad/s], samples of stretch taken so far,
# 1 once the start is known, largest energy in motion so far [J], residual so far [J].
OMEGA, SAMPLE, BEGUN, LARGEST, RESIDUE = 0, 1, 2, 3, 4
STORED = 5  # kinetic, bending, stretch, torsion, wall
AXIAL_VELOCITY, LENGTH, SAMPLES = 0, 1, 2  # rows of EnergyLedger.gauss


class EnergyLedger(NamedTuple):
    """The energy ledger of one twin."""

    entries: Array  # (10, accounts or 14) see WORK
    gauss: Array  # (5, 2 n) by Gauss point: velocity along the hole, lateral form only [m/s]; of its element the length
    # and the weights of the samples of stretch [m]
    constrained: Array  # (2, 7) unknowns that keep their constraint in the audit: none, or the bit along the hole


def make_energy_ledger(effects: int, rod: Rod, *, bit_held: bool) -> EnergyLedger:
    """An empty ledger for so many effects; `bit_held`: the bit is constrained along the hole."""
    constrained = np.zeros((2, 7))
    constrained[0, 2] = 1.0 if bit_held else 0.0
    gauss = np.stack([np.zeros(2 * rod.length.size), *np.repeat([rod.length, *rod.samples.T], 2, axis=1)])
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
    weight = gauss[SAMPLES + int(entries[NOW, SAMPLE] % 3.0), 2 * element]
    entries[POWER, account] -= weight * force * rate


@kernel
def next_sample(entries: Array) -> None:
    """Advance to the next sample of stretch."""
    entries[NOW, SAMPLE] += 1.0


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
