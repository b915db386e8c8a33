# SPDX-License-Identifier: Apache-2.0
"""The effect that a stopped run names: its load is that of the law in force."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rod_scenes import DIAMETER, rod_scene

from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.kernel_arguments import effects_of, make_drive
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.dynamics.twin.failure_report import EvaluationPoint, diagnose
from drill_twin.physics.effects import parameters_of

RADIUS, WEIGHT, DECAY, SPEED = 8e-3, 50.0, 0.5, 6.0


@pytest.mark.parametrize(
    ("exponent", "share"), [(None, np.exp(-DECAY * SPEED)), (3.0, np.exp(-((DECAY * SPEED) ** 3)))]
)
def test_the_load_of_a_variant_is_its_own(exponent: float | None, share: float) -> None:
    """At three times the decay the plain law has 5 % of its excess left, that with an exponent of 3 nothing."""
    law = {"radius": RADIUS, "sliding": 0.3, "sticking": 3.0, "decay": DECAY, "exponent": exponent}
    scene = rod_scene(effects={"stretch": {}, "torsion": {}, "bit_torque_stribeck": law}, bit_end="guided")
    model = discretise(scene, mesh(scene, 24))
    block = scene.effects.bit_torque_stribeck
    drive = make_drive(scene, 0.0)
    drive.bit.now[0] = WEIGHT
    given: Any = SimpleNamespace(drive=drive, bit_torque_stribeck=parameters_of("bit_torque_stribeck", block, model))
    u, v = np.zeros((25, 7)), np.zeros((25, 7))
    u[:, 2], u[:, 5], v[:, 6] = model.rod.arc, 1.0, SPEED
    at = EvaluationPoint(u, v, 0.0, 1e-3, np.zeros(3))
    (effect,) = effects_of(scene)
    named, said = diagnose(given, model.rod, [effect], [at])
    force = RADIUS * WEIGHT * (0.3 + 2.7 * share) / (0.5 * DIAMETER)
    assert str(effect) == ("bit_torque_stribeck" if exponent is None else "bit_torque_stribeck:exponent")
    assert named == "bit_torque_stribeck"
    assert said == f"strongest: bit_torque_stribeck ({force:.3g} N 0 m from the bit)"
