# SPDX-License-Identifier: Apache-2.0
"""The energy audit: each effect's work on the string in a step, for a scene that asks for it.

The midpoint rule makes the work of a force over a step exactly F v dt with the force and the velocity at mid-step, so
the work of all forces adds up to the change of kinetic energy to round-off. Once a step has converged, the system is
built once more with effects that record their work in the ledger: the difference that each call makes to load, section
resultants or end loads, times the velocity that it does work on. The remaining residual of the equations is, at
constrained unknowns, the reaction that drives them, and at the others the part that Newton's method left unsolved.

In the lateral form no node moves along the hole as an unknown; the axial velocity follows from the slopes, so that
gravity and weight on bit do work there too.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.model.mesh import SPIN, Rod
from drill_twin.model.point import Point
from drill_twin.model.section import COUPLE, MX, MY, MZ, RESULTANTS, TORQUE
from drill_twin.model.strain import Strain
from drill_twin.solver.boundary.bit_frame import turn_row, turn_row_back
from drill_twin.solver.boundary.rig import BIT, RESIDUAL, TOP
from drill_twin.solver.state import State

# Accounts; those of the effects follow.
WEIGHT, DRIVE, CLAMP, NEWTON, FIRST_EFFECT = 0, 1, 2, 3, 4
ACCOUNTS = ("weight_on_bit", "top_drive", "top_clamp", "newton")
# Rows of EnergyLedger.books: by account the work done on the string since the start and the part of it that an effect
# reports as heat [J], and both in the current step [W]; load (4), resultants (7) and end loads (2 times 7) before the
# next effect; velocity of the top after the step by the midpoint rule alone (7), stored energy at the start (5, see
# STORED), and the row NOW. One array: each more, passed from call to call, would cost seconds of compiling.
WORK, LOST, POWER, HEAT, LOAD, SECTION, ENDS, TOP_ROW, START, NOW = range(10)
ROWS, NARROWEST = 10, 14
# Indices into the row NOW: the material's angular velocity about the tangent [rad/s], samples of stretch taken so far,
# 1 once the start is known, largest energy in motion so far [J], residual so far [J].
OMEGA, SAMPLE, BEGUN, LARGEST, RESIDUE = 0, 1, 2, 3, 4
STORED = 5  # kinetic, bending, stretch, torsion, wall
FALL, LENGTH = 0, 1  # rows of EnergyLedger.course
ASIDE = -5.0  # number of an iteration, matched by no effect that remembers Newton's last one


class EnergyLedger(NamedTuple):
    """The energy ledger of one twin."""

    books: Array  # (10, accounts or 14) see WORK
    course: Array  # (2, 2 n) by Gauss point: velocity along the hole, lateral form only [m/s], and element's length [m]
    loose: Array  # (2, 7) unknowns that keep their constraint in the audit: none, or the bit along the hole


def make_energy_ledger(effects: int, rod: Rod, *, bit_held: bool) -> EnergyLedger:
    """An empty ledger for so many effects; `bit_held`: the bit is constrained along the hole."""
    loose = np.zeros((2, 7))
    loose[0, 2] = 1.0 if bit_held else 0.0
    course = np.stack([np.zeros(2 * rod.length.size), np.repeat(rod.length, 2)])
    return EnergyLedger(np.zeros((ROWS, max(FIRST_EFFECT + effects, NARROWEST))), course, loose)


@kernel
def open_load(books: Array, load: Array) -> None:
    """Set the load at a Gauss point that the next effect adds to."""
    for c in range(4):
        books[LOAD, c] = load[c]


@kernel
def book_load(books: Array, course: Array, account: int, here: Point, load: Array) -> None:
    """Record what an effect has added to the load at a Gauss point; a couple turns the material about the tangent."""
    along = here.vz + course[FALL, here.place]
    power = (load[0] - books[LOAD, 0]) * here.vx + (load[1] - books[LOAD, 1]) * here.vy
    power += (load[2] - books[LOAD, 2]) * along + (load[3] - books[LOAD, 3]) * books[NOW, OMEGA]
    books[POWER, account] += 0.5 * course[LENGTH, here.place] * power
    open_load(books, load)


@kernel
def book_heat(books: Array, course: Array, account: int, here: Point, power: float) -> None:
    """Record the power that an effect turns into heat at a Gauss point [W/m]."""
    books[HEAT, account] += 0.5 * course[LENGTH, here.place] * power


@kernel
def open_section(books: Array, strain: Strain, out: Array) -> None:
    """Set the angular velocity of a section and the resultants that the next effect adds to."""
    books[NOW, OMEGA] = strain.omega
    for k in range(RESULTANTS):
        books[SECTION, k] = out[k]


@kernel
def book_section(books: Array, course: Array, account: int, s: Strain, out: Array) -> None:
    """Record what an effect has added to the resultants: moments work on P q_dot = ring + omega p, and so on."""
    power = (out[MX] - books[SECTION, MX]) * (s.ring_x + s.omega * s.px)
    power += (out[MY] - books[SECTION, MY]) * (s.ring_y + s.omega * s.py)
    power += (out[MZ] - books[SECTION, MZ]) * (s.ring_z + s.omega * s.pz)
    power += (out[TORQUE] - books[SECTION, TORQUE]) * s.tau_rate - (out[COUPLE] - books[SECTION, COUPLE]) * s.omega
    books[POWER, account] -= 0.5 * course[LENGTH, s.place] * power
    open_section(books, s, out)


@kernel
def book_stretch(books: Array, course: Array, account: int, element: int, force: float, rate: float) -> None:
    """Record a viscous axial force at one of the three Simpson points of an element: both ends, then the middle."""
    share = 4.0 if books[NOW, SAMPLE] % 3.0 == 2.0 else 1.0
    books[POWER, account] -= share / 6.0 * course[LENGTH, 2 * element] * force * rate


@kernel
def next_sample(books: Array) -> None:
    """Advance to the next Simpson point."""
    books[NOW, SAMPLE] += 1.0


@kernel
def book_ends(books: Array, account: int, turning: int, v: Array, ends: Array) -> None:
    """Record what an effect has added to the forces at bit and top; torques go to the account `turning`."""
    last = v.shape[0] - 1
    for end in range(2):
        row = 0 if end == 0 else last
        for c in range(7):
            power = (ends[end, c, RESIDUAL] - books[ENDS, 7 * end + c]) * v[row, c]
            books[POWER, turning if c == SPIN else account] -= power
            books[ENDS, 7 * end + c] = ends[end, c, RESIDUAL]


@kernel
def open_books(books: Array) -> None:
    """Clear the powers of the step."""
    for k in range(books.shape[1]):
        books[POWER, k] = 0.0
        books[HEAT, k] = 0.0
        books[ENDS, k] = 0.0
    books[NOW, SAMPLE] = 0.0


@kernel
def close_books(books: Array, state: State, step: float) -> None:
    """Add the step's work to the totals; note the velocity of the top after it by the midpoint rule alone."""
    last = state.u.shape[0] - 1
    for k in range(books.shape[1]):
        books[WORK, k] += step * books[POWER, k]
        books[LOST, k] += step * books[HEAT, k]
    for c in range(7):
        books[TOP_ROW, c] = 2.0 * state.trial[last, c] - state.v[last, c]


@kernel
def close_step(parameters: Any, rod: Rod, state: State) -> None:
    """Record the work of setting the top to its prescribed velocity, which the midpoint rule alone would overshoot."""
    books, v = parameters.ledger.books, state.v
    e, last = rod.length.shape[0] - 1, state.v.shape[0] - 1
    mass = rod.mass[e]
    for c in range(2):
        change = v[last, c] - books[TOP_ROW, c]
        momentum = mass[2, 0] * v[e, c] + mass[2, 1] * v[e, 3 + c] + mass[2, 3] * v[last, 3 + c]
        momentum += mass[2, 2] * (books[TOP_ROW, c] + 0.5 * change)
        books[WORK, CLAMP] += change * momentum


def bind_spatial(build: Any) -> Callable[..., None]:
    """The audit of a step of the spatial form; `build` fills the system with effects that record their work."""

    @kernel
    def audit(
        parameters: Any, rod: Rod, work: Any, constrained: Array, state: State, command: Array, time: float, h2: float
    ) -> None:
        books, loose, last = parameters.ledger.books, parameters.ledger.loose, state.u.shape[0] - 1
        open_books(books)
        build(parameters, rod, work, loose, state, command, time, h2, False, ASIDE)
        turn_row(state.bit_frame, state.trial[0])
        for i in range(last + 1):
            for c in range(7):
                power = work.diagonal[i, c, RESIDUAL] * state.trial[i, c]
                held_rows = (i == 0 and constrained[0, c]) or (i == last and constrained[1, c])
                books[POWER, (DRIVE if c == SPIN else CLAMP) if held_rows else NEWTON] += power
        turn_row_back(state.bit_frame, state.trial[0])
        close_books(books, state, 2.0 * h2)

    return audit


def bind_lateral(build: Any) -> Callable[..., None]:
    """The audit of a step of the lateral form; `build` as for `bind_spatial`."""

    @kernel
    def audit(
        parameters: Any, rod: Rod, work: Any, constrained: Array, state: State, command: Array, time: float, h2: float
    ) -> None:
        books, loose, last = parameters.ledger.books, parameters.ledger.loose, state.u.shape[0] - 1
        open_books(books)
        shortening = sink(rod, state, h2, parameters.drive.from_top > 0.0, parameters.ledger.course[FALL])
        # the factors are left as they are, and the system is built exactly once
        half, renew, eager, firm = work.lazy[0], work.lazy[1], work.lazy[2], work.lazy[4]
        work.lazy[0], work.lazy[1], work.lazy[2], work.lazy[4] = h2, 0.0, 0.0, np.inf
        build(parameters, rod, work, loose, state, command, time, h2, False, ASIDE)
        work.lazy[0], work.lazy[1], work.lazy[2], work.lazy[4] = half, renew, eager, firm
        for i in range(last + 1):
            for k in range(4):
                c = k if k < 2 else k + 1
                power = work.right[i, k] * state.trial[i, c]
                held_rows = (i == 0 and constrained[0, c]) or (i == last and constrained[1, c])
                books[POWER, CLAMP if held_rows else NEWTON] += power
        books[POWER, WEIGHT] += (work.ends[TOP, 2, RESIDUAL] - work.ends[BIT, 2, RESIDUAL]) * shortening
        books[POWER, DRIVE] += (work.axial[3] + work.ends[BIT, SPIN, RESIDUAL]) * state.trial[last, SPIN]
        close_books(books, state, 2.0 * h2)

    return audit


@kernel
def sink(rod: Rod, state: State, h2: float, from_top: bool, fall: Array) -> float:
    """Fill in the velocity of the Gauss points along the hole, v_z(s) = int_s^top r'.r'_dot; returns that of the bit.

    Summed as the axial force is (`drill_twin.solver.lateral.assembly`), so that the work of both agrees. Where the
    weight is set at the top the bit is constrained, and the top moves instead.
    """
    above = 0.0
    for e in range(rod.length.shape[0] - 1, -1, -1):
        h, total = rod.length[e], 0.0
        for p in range(2):
            d, g = rod.shape[e, p, 1], 0.0
            for c in range(2):
                rate = (
                    d[0] * state.trial[e, c] + d[1] * state.trial[e, 3 + c]
                    + d[2] * state.trial[e + 1, c] + d[3] * state.trial[e + 1, 3 + c]
                )  # fmt: skip
                slope = (
                    d[0] * state.u[e, c] + d[1] * state.u[e, 3 + c]
                    + d[2] * state.u[e + 1, c] + d[3] * state.u[e + 1, 3 + c]
                )  # fmt: skip
                g += (slope + h2 * rate) * rate
            fall[2 * e + p] = above + rod.spin_shape[p, 1] * h * g
            total += 0.5 * h * g
        above += total
    if from_top:
        for k in range(fall.shape[0]):
            fall[k] -= above
    return above
