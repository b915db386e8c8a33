# SPDX-License-Identifier: Apache-2.0
"""The share of the cost that goes with each effect: sampled without touching the run."""

import numpy as np
import pytest

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.monitor.run_timing import EffectTiming
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command


def test_sampling_the_cost_of_effects_leaves_the_run_as_it_is():
    """The bit's friction remembers whether it sticks: timed on the run's own memory, the run would be another one."""
    scene = load_scene("two_mass")
    watched, alone = Twin(scene), Twin(scene)
    cost = EffectTiming(watched)
    for k in range(20):
        command = Command(scene.rig.weight_on_bit.initial, 0.2 * k)
        frames = [twin.advance(command, 0.02) for twin in (watched, alone)]
        values = {name: float(text) for name, text in cost.values(1.0).items()}
    np.testing.assert_array_equal(frames[0].spin, frames[1].spin)
    for name, memory in watched.checkpoint().items():
        np.testing.assert_array_equal(memory, alone.checkpoint()[name])
    assert set(values) == {f"step_cost_{name}" for name in (*watched.effects, "rod_and_solution")}
    assert sum(values.values()) == pytest.approx(1.0, abs=1e-3)


def test_shares_are_of_what_an_iteration_costs(monkeypatch):
    twin = Twin(load_scene("two_mass"))
    twin.advance(Command(0.0, 1.0), 0.02)
    assert twin.effect_timer()("bit_torque_stribeck") > 0.0
    monkeypatch.setattr(twin, "effect_timer", lambda: lambda _name: 2e-6)  # no reading of a busy clock
    cost, number = EffectTiming(twin), len(twin.effects)
    assert cost.values(0.0) == {}  # nothing to put it in relation to
    values = cost.values(8e-6 * number)
    assert values.pop("step_cost_rod_and_solution") == "0.7500"
    assert set(values) == {f"step_cost_{name}" for name in twin.effects}
    assert sum(map(float, values.values())) == pytest.approx(0.25, abs=1e-3)
    assert cost.values(1e-6)["step_cost_rod_and_solution"] == "0.0000"
