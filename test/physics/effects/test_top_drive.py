# SPDX-License-Identifier: Apache-2.0
"""The top drive: what it sends back of a torsional wave, its torque limit, and the speed it holds."""

import numpy as np
import pytest
from end_scenes import with_rig
from pydantic import ValidationError
from rod_scenes import LENGTH, rod_scene

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command

IDLE = {
    "internal_damping": {"bending_time": 0.0},
    "bit_torque_stribeck": {"radius": 0.1, "sliding": 0.5, "sticking": 0.8, "decay": 0.9},
}
"""Effects of the scene two_mass, so that no other kernel is compiled; without weight the bit torque is zero."""
ROD_INERTIA = 1100.0 * np.pi / 32.0 * 0.0165**4 * LENGTH


def driven(step: float, elements: int, **top_drive) -> Twin:
    scene = rod_scene(effects=IDLE | {"bit_mass": {}}, elements=elements, step=step)
    return Twin(with_rig(scene, top_drive=top_drive))


def test_the_motor_keeps_to_its_limit_and_then_holds_the_speed():
    """At its limit it speeds up drive and string alike by T / J; then it settles, without having wound up.

    The controller has 5 rad of lag to forget if it winds up; linear, its step response overshoots by exp(-2) = 13 %.
    """
    inertia, limit, omega = 0.05, 0.5, 10.0
    gains = {"proportional_gain": 2.0 * omega * inertia, "integral_gain": omega**2 * inertia}
    twin = driven(1e-3, 8, model="speed_controller", inertia=inertia, torque_limit=limit, **gains)
    twin.advance(Command(weight_on_bit=0.0, rotation=10.0), 1e-3)
    frames = [twin.advance(Command(weight_on_bit=0.0, rotation=10.0), 0.01).rig for _ in range(300)]
    whole = inertia + ROD_INERTIA
    speeds = np.array([frame.top_drive_speed for frame in frames])
    assert speeds[59] - speeds[19] == pytest.approx(limit / whole * 0.4, rel=2e-3)
    assert np.mean([frame.top_drive_torque for frame in frames[20:60]]) == pytest.approx(
        limit * ROD_INERTIA / whole, rel=0.05
    )
    assert speeds.max() < 10.0 * 1.14
    assert speeds[-1] == pytest.approx(10.0, abs=1e-3)


def test_a_ramp_is_followed_and_the_integral_part_takes_away_the_droop():
    """Bearings that take D Omega let a proportional drive droop to P / (P + D) of the command; an integral does not."""
    for integral, share in ((0.0, 2.0 / 2.5), (20.0, 1.0)):
        twin = driven(
            1e-3, 8, model="speed_controller", inertia=0.05, damping=0.5, proportional_gain=2.0, integral_gain=integral
        )
        for k in range(300):
            rig = twin.advance(Command(weight_on_bit=0.0, rotation=4.0 * min((k + 1) / 100.0, 1.0)), 0.01).rig
        assert rig.top_drive_speed == pytest.approx(4.0 * share, rel=1e-3)


@pytest.mark.parametrize(
    ("top_drive", "words"),
    [
        ({"inertia": 3.0}, 'expected no `inertia` with model "prescribed", found one'),
        ({"model": "speed_controller", "integral_gain": 0.0}, 'expected a number with model "speed_controller"'),
        ({"model": "speed_controller", "reflection": 0.5}, "expected no `reflection`"),
        ({"model": "impedance", "proportional_gain": 3.0, "reflection": 0.5}, "and a `proportional_gain` of its own"),
        ({"model": "impedance", "reflection": 1.0}, "-1 is a held top, 1 a free one"),
        ({"model": "impedance", "torque_limit": 0.0}, "above 0 N m"),
        ({"model": "impedance", "inertia": -1.0}, "at least 0 kg m^2"),
    ],
)
def test_what_a_top_drive_cannot_be_is_refused(top_drive, words):
    with pytest.raises(ValidationError) as caught:
        with_rig(rod_scene(effects={}), top_drive=top_drive)
    assert words in str(caught.value)


def test_without_torsion_there_is_no_top_to_drive():
    data = rod_scene(effects={}).model_dump(exclude_none=True)
    data["effects"] = {}
    data["rig"]["top_drive"] = {"model": "impedance"}
    with pytest.raises(ValidationError, match='expected "prescribed" in a scene without torsion'):
        type(rod_scene(effects={})).model_validate(data)
