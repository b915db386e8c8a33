# SPDX-License-Identifier: Apache-2.0
"""Finite elements of a rotor from the textbook, in numpy alone: no line of drill_twin.

Euler beams with Rayleigh's rotary inertia, gyroscopic moments and axial force; rigid discs, springs and dampers at
nodes (Przemieniecki 1968, ch. 5 and 11; Friswell, Penny, Garvey and Lees 2010, ch. 5). Unknowns x, x', y, y' a node.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg

Array = np.ndarray


class Shaft(NamedTuple):
    """Uniform piece of a shaft."""

    length: float
    diameter: float
    bore: float
    youngs_modulus: float
    density: float
    elements: int


class Wheel(NamedTuple):
    """Rigid disc at a place."""

    place: float
    mass: float
    polar: float
    diametral: float


class Bearing(NamedTuple):
    """Springs and dampers at a place, across, shape (2, 2) each, and against tilt."""

    place: float
    stiffness: Array
    damping: Array
    tilt: float = 0.0
    tilt_damping: float = 0.0


class Rotor(NamedTuple):
    """A rotor from its lower end up; `held` are names of fixed unknowns at both ends, of x (and y) and slopes."""

    shafts: tuple[Shaft, ...]
    wheels: tuple[Wheel, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    lower: str = ""  # "", "place", "slope" or both, "place slope"
    upper: str = ""
    gravity: float = 0.0  # along the rotor, downwards
    load: float = 0.0  # pull at the lower end, negative: push


class System(NamedTuple):
    """M q'' + (C + speed G) q' + K q = f of the free unknowns, and where they are."""

    mass: Array
    damping: Array
    gyroscopic: Array
    stiffness: Array
    places: Array
    free: Array


def _nodes(rotor: Rotor) -> tuple[Array, list[Shaft]]:
    """Places of the nodes, and the shaft of each element; wheels and bearings have nodes."""
    places, start = {0.0}, 0.0
    for shaft in rotor.shafts:
        places |= set((start + np.linspace(0.0, shaft.length, shaft.elements + 1)).tolist())
        start += shaft.length
    places |= {wheel.place for wheel in rotor.wheels} | {bearing.place for bearing in rotor.bearings}
    ordered = np.array(sorted(places))
    ordered = ordered[np.append(True, np.diff(ordered) > 1e-9 * start)]
    tops = np.cumsum([shaft.length for shaft in rotor.shafts])
    middle = 0.5 * (ordered[1:] + ordered[:-1])
    return ordered, [rotor.shafts[int(np.searchsorted(tops, m))] for m in middle]


def system(rotor: Rotor) -> System:
    """Matrices of a rotor."""
    places, shafts = _nodes(rotor)
    count = 4 * places.size
    mass, damping, gyroscopic, stiffness = (np.zeros((count, count)) for _ in range(4))
    pull = rotor.load
    for k, (h, shaft) in enumerate(zip(np.diff(places), shafts, strict=True)):
        at = places[k]
        pull += rotor.gravity * sum(w.mass for w in rotor.wheels if abs(w.place - at) < 1e-9)
        area = np.pi / 4.0 * (shaft.diameter**2 - shaft.bore**2)
        inertia = np.pi / 64.0 * (shaft.diameter**4 - shaft.bore**4)
        bend = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]) / h**3  # fmt: skip
        move = h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                                   [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]])  # fmt: skip
        turn = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h],
                         [-36, -3 * h, 36, -3 * h], [3 * h, -h * h, -3 * h, 4 * h * h]]) / (30 * h)  # fmt: skip
        own = rotor.gravity * shaft.density * area * h
        for plane in (0, 2):
            own_rows = 4 * k + plane + np.array([0, 1, 4, 5])
            part = np.ix_(own_rows, own_rows)
            mass[part] += shaft.density * (area * move + inertia * turn)
            stiffness[part] += shaft.youngs_modulus * inertia * bend + (pull + 0.5 * own) * turn
        x = 4 * k + np.array([0, 1, 4, 5])
        gyroscopic[np.ix_(x, x + 2)] += 2.0 * shaft.density * inertia * turn
        gyroscopic[np.ix_(x + 2, x)] -= 2.0 * shaft.density * inertia * turn
        pull += own
    for wheel in rotor.wheels:
        i = 4 * int(np.abs(places - wheel.place).argmin())
        mass[range(i, i + 4), range(i, i + 4)] += [wheel.mass, wheel.diametral] * 2
        gyroscopic[i + 1, i + 3] += wheel.polar
        gyroscopic[i + 3, i + 1] -= wheel.polar
    for bearing in rotor.bearings:
        i = 4 * int(np.abs(places - bearing.place).argmin())
        across = np.ix_([i, i + 2], [i, i + 2])
        stiffness[across] += bearing.stiffness
        damping[across] += bearing.damping
        for j in (i + 1, i + 3):
            stiffness[j, j] += bearing.tilt
            damping[j, j] += bearing.tilt_damping
    free = np.ones(count, bool)
    for end, held in ((0, rotor.lower), (count - 4, rotor.upper)):
        for offset, name in enumerate(("place", "slope", "place", "slope")):
            free[end + offset] = name not in held
    kept = np.ix_(free, free)
    return System(mass[kept], damping[kept], gyroscopic[kept], stiffness[kept], places, free)


def eigenvalues(found: System, speed: float, count: int) -> Array:
    """The `count` eigenvalues nearest to zero with a frequency above zero, by frequency."""
    size = found.mass.shape[0]
    top = np.hstack([np.zeros((size, size)), np.eye(size)])
    low = np.hstack([-found.stiffness, -(found.damping + speed * found.gyroscopic)])
    right = scipy.linalg.block_diag(np.eye(size), found.mass)
    # of the inverse, whose largest eigenvalues are wanted: exact where the largest of the system are 1e16 times larger
    inverse = scipy.linalg.solve(np.vstack([top, low]), right)
    values = scipy.linalg.eigvals(inverse)
    values = 1.0 / values[np.abs(values) > 0.0]
    values = values[values.imag > 1e-6 * np.abs(values)]
    return np.asarray(values[np.argsort(np.abs(values))][:count])


def response(found: System, speed: float, place: float, unbalance: complex, probe: float) -> complex:
    """Complex x of a probe [m], Re(x exp(i speed t)), by an unbalance [kg m] that is at +x at t = 0 for angle 0."""
    force = np.zeros(found.free.size, complex)
    i = 4 * int(np.abs(found.places - place).argmin())
    force[i], force[i + 2] = unbalance * speed**2, -1j * unbalance * speed**2
    dynamic = found.stiffness - speed**2 * found.mass + 1j * speed * (found.damping + speed * found.gyroscopic)
    moved = np.zeros(found.free.size, complex)
    moved[found.free] = np.linalg.solve(dynamic, force[found.free])
    return complex(moved[4 * int(np.abs(found.places - probe).argmin())])
