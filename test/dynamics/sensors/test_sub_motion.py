# SPDX-License-Identifier: Apache-2.0
"""Readings of perfect sensors in a sub, against closed forms."""

import math

import numpy as np
import pytest

from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.dynamics.sensors.motion import locate, sub_motion, true_readings
from drill_twin.physics.model.mesh import Rod
from drill_twin.scene import load_scene, parse_scene

ROTATION, WHIRL, RADIUS, ORBIT = math.tau * 2.0, -math.tau * 1.3, 0.007, 0.05
STEP = 1e-4
FALL = 9.81


def rod() -> Rod:
    return mesh(load_scene("pa6_bench"), 8)


def straight(time: np.ndarray, *, whirl: float = 0.0, rotation: float = ROTATION, spun: float = 0.0) -> tuple:
    """States u, v of shape (T, n + 1, 7) of a straight string that turns about an axis that goes round a circle."""
    arc = rod().arc
    u, v = np.zeros((2, time.size, arc.size, 7))
    z = ORBIT * np.exp(1j * whirl * time) if whirl else np.zeros_like(time, complex)
    u[..., 0], u[..., 1], u[..., 2] = z.real[:, None], z.imag[:, None], arc
    speed = 1j * whirl * z
    v[..., 0], v[..., 1] = speed.real[:, None], speed.imag[:, None]
    u[..., 5] = 1.0
    u[..., 6], v[..., 6] = (rotation * time + 0.5 * spun * time**2)[:, None], (rotation + spun * time)[:, None]
    return u, v


def read(time: np.ndarray, u: np.ndarray, v: np.ndarray, gravity: tuple = (0.0, 0.0, -FALL)) -> np.ndarray:
    places = locate(rod(), np.array([1.234]), np.array([RADIUS]), np.array([0.3]))
    before, after = sub_motion(places, u[:-1], v[:-1]), sub_motion(places, u[1:], v[1:])
    return true_readings(places, before, after, float(time[1] - time[0]), np.array(gravity))[:, 0]


TIME = np.arange(2001) * STEP


def test_steady_rotation_is_r_omega_squared_towards_the_axis() -> None:
    found = read(TIME, *straight(TIME))
    exact = [-RADIUS * ROTATION**2, 0.0, FALL, 0.0, 0.0, ROTATION]
    np.testing.assert_allclose(found, np.broadcast_to(exact, found.shape), atol=1e-10)


def test_angular_acceleration_is_tangential() -> None:
    found = read(TIME, *straight(TIME, spun=3.0))
    np.testing.assert_allclose(found[:, 1], RADIUS * 3.0, atol=1e-10)


def test_circular_whirl_is_a_line_at_the_difference_of_speeds() -> None:
    found = read(TIME, *straight(TIME, whirl=WHIRL))
    middle = 0.5 * (TIME[1:] + TIME[:-1])
    lateral = found[:, 0] + 1j * found[:, 1] + RADIUS * ROTATION**2
    shrunk = np.sinc(WHIRL * STEP / math.tau)  # mean over the interval of a sample
    line = -ORBIT * WHIRL**2 * shrunk * np.exp(1j * ((WHIRL - ROTATION) * middle - 0.3))
    np.testing.assert_allclose(lateral, line, atol=1e-9)


def test_gravity_in_an_inclined_hole_is_a_line_at_the_rotation() -> None:
    lean = math.radians(40.0)
    found = read(TIME, *straight(TIME), gravity=(FALL * math.sin(lean), 0.0, -FALL * math.cos(lean)))
    middle = 0.5 * (TIME[1:] + TIME[:-1])
    line = -FALL * math.sin(lean) * np.exp(-1j * (ROTATION * middle + 0.3)) - RADIUS * ROTATION**2
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], line, atol=1e-9)
    np.testing.assert_allclose(found[:, 2], FALL * math.cos(lean), atol=1e-9)


def test_rates_are_those_of_the_attitude() -> None:
    """A conical motion: the rates are compared with the matrices of the attitude, differenced in time."""
    arc, tilt, step = rod().arc, 0.2, 1e-5
    time = np.arange(5) * step
    u, v = np.zeros((2, time.size, arc.size, 7))
    lean, turn = math.sin(tilt) * np.exp(1j * WHIRL * time), 1j * WHIRL * math.sin(tilt) * np.exp(1j * WHIRL * time)
    for array, value in ((u, lean), (v, turn)):
        array[..., 3], array[..., 4] = value.real[:, None], value.imag[:, None]
        array[..., 0], array[..., 1] = value.real[:, None] * arc, value.imag[:, None] * arc
    u[..., 5], u[..., 2] = math.cos(tilt), math.cos(tilt) * arc
    u[..., 6], v[..., 6] = ROTATION * time[:, None], ROTATION
    places = locate(rod(), np.array([1.0]), np.zeros(1), np.zeros(1))
    motion = sub_motion(places, u, v)
    attitude = np.array([_matrix(t, s) for t, s in zip(motion.tangent[:, 0], motion.spin[:, 0], strict=True)])
    turned = (attitude[1].T @ (attitude[2] - attitude[0])) / (2.0 * step)  # R^T dR/dt, skew
    np.testing.assert_allclose(motion.rate[1, 0], [turned[2, 1], turned[0, 2], turned[1, 0]], atol=1e-6)


def _matrix(t: np.ndarray, spin: float) -> np.ndarray:
    """Attitude: the smallest rotation of z to t (Rodrigues), after the spin about z."""
    axis = np.array([-t[1], t[0], 0.0])
    cross = np.array([[0.0, 0.0, axis[1]], [0.0, 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    smallest = np.eye(3) + cross + cross @ cross / (1.0 + t[2])
    c, s = math.cos(spin), math.sin(spin)
    return smallest @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def test_members_of_an_ensemble_are_read_at_once() -> None:
    u, v = straight(TIME, whirl=WHIRL)
    one = read(TIME, u, v)
    places = locate(rod(), np.array([1.234]), np.array([RADIUS]), np.array([0.3]))
    both = [np.stack([w, w]) for w in (u, v)]
    before, after = (sub_motion(places, *(w[:, rows] for w in both)) for rows in (slice(-1), slice(1, None)))
    np.testing.assert_array_equal(true_readings(places, before, after, STEP, np.array([0.0, 0.0, -FALL]))[1, :, 0], one)


def test_scene_with_sensors_is_checked() -> None:
    text = load_scene("pa6_bench").to_yaml()
    sub = "{name: a, distance_from_bit: 1 m, rate: 200 Hz, radius: 1 m}"
    with pytest.raises(Exception, match=r"at most numerics.frame_rate \(100 Hz\)"):
        parse_scene(text, name="x", overrides={"sensors.subs": f"[{sub}]"})


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        ("subs", "rate: 30 Hz", r"over a whole number.*found 30 Hz; 25 Hz or 33.3333 Hz fits"),
        ("surface", "rate: 0.01 Hz", r"a sample within rig.duration \(30 s\), found 0.01 Hz"),
        ("surface", "rate: 10 Hz, delay: 30 s", r"less than rig.duration \(30 s\), found 30 s: no reading would come"),
    ],
)
def test_an_instrument_without_even_samples_or_readings_is_refused(place: str, value: str, told: str) -> None:
    text = load_scene("pa6_bench").to_yaml()
    block = f"[{{name: a, distance_from_bit: 1 m, {value}}}]" if place == "subs" else f"{{{value}}}"
    overrides = {f"sensors.{place}": block, "rig.duration": "30 s"}
    with pytest.raises(Exception, match=told):
        parse_scene(text, name="x", overrides=overrides)
    parse_scene(text, name="x", overrides={**overrides, f"sensors.{place}": block.replace(value, "rate: 33.3333 Hz")})
