# SPDX-License-Identifier: Apache-2.0
"""The string on the wall: the helix of a buckled weightless rod, and pure rolling."""

import numpy as np
import pytest
from scenes import DIAMETER, EI, ROLLING, rod_scene

from drill_twin.schedule.command import Command
from drill_twin.twin import Twin

SETTLED = {
    "bow": {"amplitude": 2e-3},
    "drag": {"linear": 3.0},
    "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "wall": {"stiffness": 1e7},
}


@pytest.fixture(scope="module")
def helix() -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Arc [m], centre line x + i y [m], nodal wall force [N] and load [N] of a buckled rod of ten pitches, at rest."""
    load, length, elements = 300.0, 15.0, 120
    kick = {"lateral_kick": {"velocity": 0.02, "shape": "hump"}}
    scene = rod_scene(effects=SETTLED | kick, length=length, elements=elements, step=2e-3, radius=0.02 + DIAMETER / 2)
    twin = Twin(scene)
    for k in range(500):
        t = (k + 1) * 0.02
        frame = twin.step(Command(weight_on_bit=load * min(t / 4.0, 1.0), rotation=0.3 * (t < 3.0)), 0.02)
    assert np.abs(frame.velocities).max() < 1e-3
    return twin.rod.arc, frame.positions[:, 0] + 1j * frame.positions[:, 1], frame.wall_force, load


def test_helix_pitch_and_contact_force(helix: tuple[np.ndarray, np.ndarray, np.ndarray, float]) -> None:
    """Interior of both windings: pitch 2 pi sqrt(2 EI / F) (Lubinski, Althouse and Logan 1962), force F^2 r / (4 EI).

    Both formulas are for small slopes; the helix climbs at 0.085, so 0.4 % and 1.5 % are allowed. A rod held at both
    ends winds both ways and turns round in the middle: the places of turning are no part of the interior.
    """
    arc, centre, force, load = helix
    length = arc[-1]
    pitch = 2.0 * np.pi * np.sqrt(2.0 * EI / load)
    assert length / pitch > 8.0
    winding = np.gradient(np.unwrap(np.angle(centre)), arc)
    inside = (np.abs(arc / length - 0.25) < 0.13) | (np.abs(arc / length - 0.75) < 0.13)
    steady = inside & (np.abs(np.abs(winding) / np.median(np.abs(winding[inside])) - 1.0) < 0.05)
    assert steady.sum() > 0.8 * inside.sum()
    assert 2.0 * np.pi / np.abs(winding[steady]).mean() == pytest.approx(pitch, rel=4e-3)
    per_metre = force[steady] / (length / (arc.size - 1))
    assert per_metre.mean() == pytest.approx(load**2 * np.abs(centre[steady]).mean() / (4.0 * EI), rel=0.015)


def test_pure_rolling() -> None:
    """With friction enough to stick, the string rolls backward at r_pipe / r_orbit of the rotation, within 0.2 %."""
    twin = Twin(rod_scene(effects=ROLLING, step=2e-3, radius=0.04))
    angle, radius = [], []
    iterations, steps = 0, 0
    for k in range(1000):
        share = min((k + 1) * 0.01 / 2.0, 1.0)
        frame = twin.step(Command(weight_on_bit=30.0 * share, rotation=2.0 * np.pi * share), 0.01)
        place = complex(*frame.marks.centre[0, :2])
        angle.append(np.angle(place))
        radius.append(abs(place))
        iterations, steps = iterations + frame.stats.iterations, steps + frame.stats.steps
    assert iterations < 2.5 * steps, "Newton must not circle about the kink of the friction law"
    turned = np.unwrap(angle[-500:])
    ratio = (turned[-1] - turned[0]) / (499 * 0.01) / (2.0 * np.pi)
    assert ratio == pytest.approx(-0.5 * DIAMETER / np.mean(radius[-500:]), rel=2e-3)
