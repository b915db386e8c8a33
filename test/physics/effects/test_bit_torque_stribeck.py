# SPDX-License-Identifier: Apache-2.0
"""Friction of the bit that falls with speed, with and without an exponent of the decay."""

import numpy as np
import pytest
from jsonschema import Draft7Validator
from numba.core.dispatcher import Dispatcher
from pydantic import ValidationError
from rod_scenes import WALLED

from drill_twin.api import load_scene
from drill_twin.core.compile.jit import as_python
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.bit_torque_stribeck import (
    BitTorqueStribeck,
    Parameters,
    end_load,
    friction,
    friction_exponent,
    parameters,
)
from drill_twin.scene.json_schema import scene_json_schema
from drill_twin.scene.set_points.command import Command

IDLE = ("gravity", "bow", "eccentricity", "drag", "wall", "wall_friction")
"""With these, at zero, the effects are those of pa6_bench, and no other kernel is compiled."""
LAW = Parameters(0.1, 0.2, 0.5, 0.3, 1e-4, np.zeros(5), 1.0, 0.0)


@pytest.mark.parametrize("speed", [0.01, 1.0, 7.0])
def test_an_exponent_of_1_is_the_law_without_one(speed):
    assert friction_exponent.py_func(LAW, 100.0, speed) == pytest.approx(friction.py_func(LAW, 100.0, speed), rel=1e-4)


@pytest.mark.parametrize("exponent", [1.3, 2.0, 6.0])
@pytest.mark.parametrize("speed", [0.1, 2.0, -4.0])
def test_the_slope_is_that_of_the_limit(exponent, speed):
    law = LAW._replace(exponent=exponent)
    up, down = (friction_exponent.py_func(law, 100.0, abs(speed) + change)[0] for change in (1e-5, -1e-5))
    limit, slope, _ = friction_exponent.py_func(law, 100.0, speed)
    assert limit == pytest.approx(10.0 * (0.2 + 0.3 * np.exp(-((0.3 * abs(speed)) ** exponent))), rel=1e-6)
    assert slope == pytest.approx((up - down) / 2e-5, rel=1e-5, abs=1e-7)


def test_a_bit_that_turns_steadily_feels_the_limit_of_its_speed():
    law = {"radius": 0.05, "sliding": 0.1, "sticking": 0.3, "decay": "0.02 s/rad", "exponent": 2.0}
    scene = load_scene("two_mass", {"effects.bit_torque_stribeck": law})
    twin = Twin(scene)
    for _ in range(200):
        rig = twin.advance(Command(500.0, 60.0), 0.1).rig
    expected = 0.05 * rig.bit_force * (0.1 + 0.2 * np.exp(-((0.02 * rig.bit_speed) ** 2)))
    assert -rig.bit_torque == pytest.approx(expected, rel=1e-3)


def test_a_bit_drills_with_the_work_of_its_sliding_torque():
    law = {"radius": 0.1, "sliding": 0.4, "sticking": 0.5, "decay": "0.9 s/rad", "specific_energy": "170 MPa"}
    twin = Twin(load_scene("two_mass", {"effects.bit_torque_stribeck": law}))
    for _ in range(100):
        rig = twin.advance(Command(500.0, 20.0), 0.1).rig
    rate = 0.1 * rig.bit_force * 0.4 * rig.bit_speed / (np.pi * 0.15**2 * 170e6)
    assert rig.rate_of_penetration == pytest.approx(rate, rel=5e-3)  # the mean of a frame
    assert 0.0 < rig.drilled < 10.0 * rate


@pytest.mark.parametrize(("bit", "low", "high"), [
    ("pdc", 3.0, 5.0), ("roller_cone", 0.78, 1.56), ("hybrid", 1.56, 3.1), ("bicentre", 3.1, 5.7),
])  # fmt: skip
def test_a_type_of_bit_has_the_torque_of_its_range(bit, low, high):
    """8 1/2 in under 22 klbf while it slides [kft lbf]; 36 T / (D W) of Pessier and Fear is the coefficient."""
    block = BitTorqueStribeck.model_validate({"bit": bit, "radius": f"{8.5 / 3.0} in"})
    law = parameters(block, None)
    torque = friction.py_func(law, 22e3 * 4.4482216, 20.0)[0] / 1355.8179
    assert low < torque < high
    assert 36.0 * torque / (8.5 * 22.0) == pytest.approx(block.sliding, rel=1e-5)
    assert friction.py_func(law, 1.0, 0.0)[0] > friction.py_func(law, 1.0, 20.0)[0]


def test_a_number_beside_a_type_takes_its_place_and_without_a_type_none_is_assumed():
    block = BitTorqueStribeck.model_validate({"bit": "pdc", "radius": 0.07, "sticking": 0.9})
    assert (block.sliding, block.sticking) == (0.7, 0.9)
    assert BitTorqueStribeck.model_validate(block.model_dump()) == block
    for wrong, said in (({"radius": 0.07}, "sliding"), ({"bit": "drag", "radius": 0.07}, "roller_cone")):
        with pytest.raises(ValidationError, match=said):
            BitTorqueStribeck.model_validate(wrong)


def test_a_type_is_checked_before_its_numbers_in_any_case():
    """One error, which lists the types."""
    assert BitTorqueStribeck.model_validate({"bit": "PDC", "radius": 0.07}).sliding == 0.7
    for wrong in ("tricone", 3, True):
        with pytest.raises(ValidationError, match="`bit`: expected a type, pdc, roller_cone, hybrid, bicentre") as told:
            BitTorqueStribeck.model_validate({"bit": wrong, "radius": 0.07})
        assert told.value.error_count() == 1


def test_a_scene_file_names_a_type(tmp_path):
    numbers = "sliding: ~, sticking: ~, decay: ~"
    text = f"base: two_mass\nname: typed\neffects: {{bit_torque_stribeck: {{bit: hybrid, {numbers}}}}}\n"
    (tmp_path / "typed.yaml").write_text(text)
    law = load_scene(tmp_path / "typed.yaml").effects.bit_torque_stribeck
    assert (law.bit, law.sliding, law.sticking, law.decay) == ("hybrid", 0.45, 0.65, 0.9)


def test_the_schema_takes_a_type_or_the_numbers():
    check = Draft7Validator(scene_json_schema()["definitions"]["BitTorqueStribeck"]).is_valid
    assert check({"bit": "pdc", "radius": "72 mm"})
    assert check({"radius": "72 mm", "sliding": 0.4, "sticking": 0.5, "decay": "0.9 s/rad"})
    assert not check({"radius": "72 mm", "sliding": 0.4})


def test_a_law_bound_to_its_load_runs_outside_of_compiled_code():
    """As the report of a failure calls it."""
    found = as_python(end_load).__closure__[0].cell_contents
    assert not isinstance(found, Dispatcher)
    assert found(LAW, 100.0, 1.0)[0] == pytest.approx(10.0 * (0.2 + 0.3 * np.exp(-0.3)), rel=1e-6)


def _torque_at_release(step, bit):
    """Largest torque on a string that is wound up until its bit slips, and the time of that."""
    scene = load_scene("two_mass", {"numerics.step": step, "rig.top_drive": {"model": "prescribed"}, **bit})
    twin, largest = Twin(scene), 0.0
    while twin.time < 10.0:
        rig = twin.advance(Command(30e3, 3.0), 0.02).rig
        largest = max(largest, rig.top_drive_torque)
        if rig.bit_angle > 0.01:
            return largest, twin.time
    raise AssertionError("the bit never slipped")


@pytest.mark.parametrize(
    "bit",
    [
        {},
        {
            "effects.bit_torque_stribeck": False,
            "effects.bit_mass": False,
            "effects.bit_friction": {"coefficient": 0.8, "radius": 0.155},
            "string.bit_end": "sliding",
            **{f"effects.{key}": WALLED[key] for key in IDLE},
        },
    ],
    ids=["stribeck", "friction"],
)
def test_a_bit_slips_at_its_friction_whatever_the_step(bit):
    """A tolerance of 1e-5 rad is 1e-3 rad/s in a step of 20 ms, ten times the width of the law at zero speed."""
    coarse, fine = _torque_at_release("20 ms", bit), _torque_at_release("1 ms", bit)
    assert coarse == pytest.approx(fine, rel=0.02)
