# SPDX-License-Identifier: Apache-2.0
"""The top drive: what it sends back of a torsional wave, its torque limit, and the speed it holds."""

import math
from typing import Any

import numpy as np
import pytest
from end_scenes import steel, with_rig
from pydantic import ValidationError
from rod_scenes import LENGTH, rod_scene
from summaries import summarise

from drill_twin.dynamics.discretisation.kernel_arguments import _torsion_of_the_string
from drill_twin.dynamics.solver.boundary import STEADY
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs import Session
from drill_twin.scene import Scene
from drill_twin.scene.blocks.top_drive import TopDrive
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


def soft(damping: float = 1500.0, seconds: float = 60.0, **parts: Any) -> Scene:
    """A kilometre of drill pipe whose bit is resisted in proportion to its speed [N m s/rad], and a soft drive."""
    law = IDLE["bit_torque_stribeck"]
    data = steel({"bit_mass": {"inertia": 50.0, "damping": damping}, "bit_torque_stribeck": law}).model_dump(
        exclude_none=True
    )
    data["string"]["sections"] = [{"length": 1000.0, "outer_diameter": 0.127, "inner_diameter": 0.1086}]
    data["numerics"] = {"elements": 12, "step": 5e-3, "frame_rate": 50.0}
    drive = {"model": "impedance", "inertia": 3000.0}
    data["rig"] = {"weight_on_bit": {"value": 0.0}, "rotation": {"value": 15.0}, "duration": seconds}
    data["rig"] |= {"top_drive": drive} | parts
    return Scene.model_validate(data)


def test_a_soft_drive_spins_up_stiff_and_goes_over_without_a_jump():
    """A ramp of 10 s to 15 rad/s, where 22.5 kN m resist; then a small and a large change of the set-point."""
    twin, gains = Twin(soft()), []
    drive, rows = twin.dynamics.parameters.drive, []
    for k in range(1500):
        rows.append(twin.advance(Command(0.0, min(0.03 * (k + 1), 15.0)), 0.02).rig)
        gains.append(drive.memory[STEADY] >= drive.wait)
    speed, torque = (np.array([getattr(row, name) for row in rows]) for name in ("top_drive_speed", "top_drive_torque"))
    begun = 500 + int(np.argmax(gains[500:]))
    assert not any(gains[10:begun])
    assert 50.0 * drive.wait - 60 < begun - 500 < 50.0 * drive.wait + 100
    assert np.abs(speed[begun:] - 15.0).max() < 0.5
    assert np.ptp(torque[begun - 3 : begun + 4]) < 0.01 * torque[begun]
    for wanted, stays in ((15.7, True), (18.0, False)):
        twin.advance(Command(0.0, wanted), 0.02)
        assert bool(drive.memory[STEADY] >= drive.wait) == stays


def test_a_soft_drive_that_starts_in_balance_holds_torque_and_speed():
    twin = Twin(soft(start="equilibrium"))
    frames = [twin.advance(Command(0.0, 15.0), 0.02).rig for _ in range(500)]
    assert np.allclose([frame.top_drive_speed for frame in frames], 15.0, rtol=1e-3)
    assert np.allclose([frame.bit_speed for frame in frames], 15.0, rtol=1e-3)
    assert np.allclose([frame.top_drive_torque for frame in frames], 1500.0 * 15.0, rtol=2e-3)


def test_a_soft_drive_absorbs_the_swing_that_a_stiff_one_keeps():
    """A swing of the first mode, ten periods on."""
    left = {}
    for model, more in (("impedance", {}), ("speed_controller", {"proportional_gain": 1e6, "integral_gain": 1e6})):
        twin = Twin(soft(damping=0.0, top_drive={"model": model, "inertia": 3000.0} | more, start="equilibrium"))
        _, v = twin.unknowns
        v[:, 6] += np.cos(0.5 * np.pi * twin.rod.arc / 1000.0)
        period = math.tau / _torsion_of_the_string(twin.scene)[1]
        swing = [twin.advance(Command(0.0, 15.0), 0.02).rig.bit_speed - 15.0 for _ in range(round(550.0 * period))]
        left[model] = np.ptp(swing[-round(50.0 * period) :]) / np.ptp(swing[: round(50.0 * period)])
    assert left["impedance"] < 0.05
    assert left["speed_controller"] > 0.5


@pytest.mark.parametrize("inertia", [0.0, 3000.0])
def test_a_tuned_drive_has_the_impedance_of_its_reflection_at_the_first_frequency(inertia):
    """Impedance Z_0 (1 - r) / (1 + r), with a reactance of a tenth; two lines: tan(w t_1) tan(w t_2) = Z_2 / Z_1."""
    data = steel({}).model_dump(exclude_none=True)
    data["string"]["sections"] = [
        {"length": 250.0, "outer_diameter": 0.2}, {"length": 2750.0, "outer_diameter": 0.1},
    ]  # fmt: skip
    impedance, frequency = _torsion_of_the_string(Scene.model_validate(data))
    speed = np.sqrt(206.8e9 / 2.0 / 1.3 / 7850.0)
    assert np.tan(frequency * 250.0 / speed) * np.tan(frequency * 2750.0 / speed) == pytest.approx(1.0 / 16.0, rel=1e-3)
    found = TopDrive(model="impedance", inertia=inertia, reflection=0.3, cancelled_inertia=0.5).tuning(
        impedance, frequency
    )
    felt = inertia - found.cancelled
    whole = 1j * felt * frequency + found.proportional + found.integral / (1j * frequency)
    assert abs((impedance - whole) / (impedance + whole)) == pytest.approx(0.3, abs=0.01)
    assert felt == 0.5 * inertia
    stiff, slow = found.spin_up
    assert stiff**2 >= 4.0 * inertia * slow


def test_a_set_point_that_is_missed_is_told(tmp_path):
    """A motor of 5 kN m cannot turn what needs 22.5 kN m at the set-point; one without a limit can."""
    for limit, said in (({"torque_limit": 5e3}, ["the top drive missed its set-point of 143.2 rpm"]), ({}, [])):
        scene = soft(seconds=40.0, top_drive={"model": "impedance", "inertia": 3000.0} | limit)
        notes = summarise(Session(scene).run(tmp_path / str(len(said))).bag)["notes"]
        assert [note.partition(":")[0] for note in notes if "missed its" in note] == said


@pytest.mark.parametrize(
    ("top_drive", "words"),
    [
        ({"inertia": 3.0}, 'expected no `inertia` with model "prescribed", found one'),
        ({"model": "speed_controller", "integral_gain": 0.0}, 'expected a number with model "speed_controller"'),
        ({"model": "speed_controller", "reflection": 0.5}, "expected no `reflection`"),
        ({"model": "speed_controller", "cancelled_inertia": 0.5}, "expected no `cancelled_inertia`"),
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
