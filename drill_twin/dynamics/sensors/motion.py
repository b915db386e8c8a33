# SPDX-License-Identifier: Apache-2.0
"""Accelerations and rates of rotation in a sub that turns with the string, from the state of the string.

The axes of a sub turn with it: x outwards through the sensor, y in the sense of positive spin, z along the string
towards the top. Accelerometers measure the specific force f = a - g: at rest they read gravity upwards. A sensor at
radius r in a sub that turns steadily at Omega reads r Omega^2 towards the axis (-x): its proof mass is pushed outwards.
A centre line on a circle of radius R at omega reads R omega^2, in the sub at the frequency |Omega - omega|; gravity in
an inclined hole is a line at Omega.

All functions take arrays with any leading dimensions: times, members of an ensemble.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.physics.model import mesh
from drill_twin.physics.model.mesh import Rod
from drill_twin.physics.model.strain import transverse_axes


class SubPlaces(NamedTuple):
    """Places of s sensors."""

    element: NDArray[np.int64]
    """Element of the mesh, shape (s,)."""
    shape: Array
    """Shape functions and their first derivatives there, shape (s, 2, 4)."""
    share: Array
    """Coordinate in the element, 0 to 1, shape (s,)."""
    radius: Array
    """Distance of the sensor from the axis of the collar [m], shape (s,)."""
    angle: Array
    """Direction of the sensor from the zero of the spin [rad], shape (s,)."""


class SubMotion(NamedTuple):
    """Motion of the sections that carry the sensors, at one instant."""

    velocity: Array
    """Velocity of the centre line in the frame `hole` [m/s], shape (..., s, 3)."""
    tangent: Array
    """Unit tangent towards the top, shape (..., s, 3)."""
    spin: Array
    """Direction of the sensor about the tangent [rad], shape (..., s)."""
    rate: Array
    """Rate of rotation about the axes of the sub [rad/s], shape (..., s, 3)."""


def locate(rod: Rod, distance_from_bit: Array, radius: Array, angle: Array) -> SubPlaces:
    """Places of sensors in a mesh.

    Args:
        rod: The string.
        distance_from_bit: Arc lengths of the sensors from the bit [m], shape (s,).
        radius: Their distances from the axis of the collar [m], shape (s,).
        angle: Their directions from the zero of the spin [rad], shape (s,).
    """
    element, share, shape = mesh.locate(rod, distance_from_bit)
    return SubPlaces(element, shape[:, :2].copy(), share, np.asarray(radius, float), np.asarray(angle, float))


def sub_motion(places: SubPlaces, u: Array, v: Array) -> SubMotion:
    """Motion of the sections that carry the sensors.

    Args:
        places: The sensors.
        u: Node rows (r, r', psi), shape (..., n + 1, 7).
        v: Their velocities.
    """
    low, high = places.element, places.element + 1
    ends = [np.stack([w[..., low, 0:3], w[..., low, 3:6], w[..., high, 0:3], w[..., high, 3:6]], -2) for w in (u, v)]
    value, slope = places.shape[:, 0, :, None], places.shape[:, 1, :, None]
    velocity = (value * ends[1]).sum(-2)
    stretch, turning = (slope * ends[0]).sum(-2), (slope * ends[1]).sum(-2)
    length = np.sqrt((stretch**2).sum(-1, keepdims=True))
    tangent = stretch / length
    swing = (turning - tangent * (tangent * turning).sum(-1, keepdims=True)) / length  # rate of the tangent
    spin, spin_rate = ((1.0 - places.share) * w[..., low, 6] + places.share * w[..., high, 6] for w in (u, v))
    spin = spin + places.angle
    across = tangent[..., 0] * swing[..., 1] - tangent[..., 1] * swing[..., 0]
    axial = spin_rate - across / (1.0 + tangent[..., 2])  # the smallest rotation that takes z to t turns about t too
    x, y = _across(tangent, spin)
    rate = np.stack([-(swing * y).sum(-1), (swing * x).sum(-1), axial], -1)
    return SubMotion(velocity, tangent, spin, rate)


def true_readings(places: SubPlaces, before: SubMotion, after: SubMotion, seconds: float, gravity: Array) -> Array:
    """Mean readings of perfect sensors over an interval, shape (..., s, 6): specific force [m/s^2], rates [rad/s].

    The mean acceleration of the centre line is its change of velocity; it is turned by the attitude in the middle of
    the interval.

    Args:
        places: The sensors.
        before: Motion at the start of the interval.
        after: Motion at its end.
        seconds: Its length [s].
        gravity: Acceleration of free fall in the frame `hole` [m/s^2], shape (3,).
    """
    tangent = before.tangent + after.tangent
    tangent /= np.sqrt((tangent**2).sum(-1, keepdims=True))
    turned = (after.rate - before.rate) / seconds
    acceleration = (after.velocity - before.velocity) / seconds
    return instantaneous(
        places.radius, acceleration - gravity, tangent, 0.5 * (before.spin + after.spin),
        0.5 * (before.rate + after.rate), turned,
    )  # fmt: skip


def instantaneous(radius: Array, force: Array, tangent: Array, spin: Array, rate: Array, turned: Array) -> Array:
    """Readings of perfect sensors at an instant, shape (..., s, 6): specific force [m/s^2], rates [rad/s].

    The acceleration of a point that is fixed in the sub is the acceleration of the centre line, plus alpha x rho +
    omega x (omega x rho) with rho = (r, 0, 0).

    Args:
        radius: Distance of the sensors from the axis of the collar [m], shape (s,).
        force: Acceleration of the centre line less gravity, in the frame `hole` [m/s^2], shape (..., s, 3).
        tangent: Unit tangent, shape (..., s, 3).
        spin: Direction of the sensor about it [rad], shape (..., s).
        rate: Rate of rotation about the axes of the sub, omega [rad/s], shape (..., s, 3).
        turned: Its rate of change, alpha [rad/s^2], shape (..., s, 3).
    """
    x, y = _across(tangent, spin)
    p, q, r = rate[..., 0], rate[..., 1], rate[..., 2]
    radial = (force * x).sum(-1) - radius * (q * q + r * r)
    tangential = (force * y).sum(-1) + radius * (turned[..., 2] + p * q)
    axial = (force * tangent).sum(-1) + radius * (p * r - turned[..., 1])
    return np.stack([radial, tangential, axial, p, q, r], -1)


def _across(tangent: Array, spin: Array) -> tuple[Array, Array]:
    """Axes x and y of the subs in the frame `hole`: the smallest rotation that takes z to t, after the spin."""
    x, y = transverse_axes(tangent)
    cos, sin = np.cos(spin)[..., None], np.sin(spin)[..., None]
    return cos * x + sin * y, cos * y - sin * x
