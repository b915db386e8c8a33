# SPDX-License-Identifier: Apache-2.0
"""Stress and fatigue of chosen sections: rainflow as the standard and pylife have it, and what a scene may ask for."""

import numpy as np
import pytest
from rod_scenes import FATIGUE, ROLLING, STRESSED, WALLED, quiet_scene

from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model import rainflow
from drill_twin.physics.model.section_stress import CYCLES, DAMAGE
from drill_twin.physics.model.steel import CURVES, GRADES, steel_of
from drill_twin.runs.loop import RunLoop
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command

ADD, TURN = as_python(rainflow.add_stress), as_python(rainflow.add_turning_point)
CUBIC = rainflow.Law(1.0, 1.0, 3.0, 3.0, 1e-9)
TURNING = Command(weight_on_bit=30.0, rotation=6.0)


def counted(signal, law=CUBIC, factor=1.0, tensile=np.inf):
    """Damage and cycles of a whole record, its last sample taken as a turning point."""
    memory, points, halves = np.zeros(rainflow.MEMORY), np.zeros(rainflow.DEPTH), np.zeros(rainflow.DEPTH)
    memory[rainflow.EXTREME] = np.nan
    for value in signal:
        ADD(law, factor, tensile, float(value), memory, points, halves)
    TURN(law, factor, tensile, memory[rainflow.EXTREME], memory, points, halves)
    return as_python(rainflow.total_damage)(memory, halves), as_python(rainflow.total_cycles)(memory)


def test_the_example_of_the_standard():
    """ASTM E1049-85, figure 6: half cycles of 3, 6 and 9, one and a half of 4, one of 8."""
    damage, cycles = counted([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert cycles == 4.0
    assert damage == pytest.approx(0.5 * (3**3 + 6**3 + 9**3) + 1.5 * 4**3 + 8**3)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_records_as_pylife_counts_them(seed):
    stress = pytest.importorskip("pylife.stress.rainflow", reason="pylife is not installed (extra bench)")
    signal = np.cumsum(np.random.default_rng(seed).normal(size=1500))
    recorder = stress.LoopValueRecorder()
    left = stress.FourPointDetector(recorder=recorder).process(signal).residuals
    ranges = np.abs(np.subtract(recorder.values_from, recorder.values_to))
    damage, cycles = counted(signal)
    assert cycles == len(ranges) + 0.5 * (len(left) - 1)
    assert damage == pytest.approx((ranges**3).sum() + 0.5 * (np.abs(np.diff(left)) ** 3).sum(), rel=1e-12)


def test_a_long_decay_is_counted_within_the_memory():
    """Nothing is closed before the last swing; what is dropped counts half, as at the end."""
    swing = 0.99 ** np.arange(300) * (-1.0) ** np.arange(300)
    damage, cycles = counted(swing)
    assert cycles == 0.5 * 299
    assert damage == pytest.approx(0.5 * (np.abs(np.diff(swing)) ** 3).sum(), rel=1e-12)


def test_small_ranges_mean_stress_and_concentration():
    small = CUBIC._replace(smallest=0.5)
    assert counted([0, 10, 9.8, 10, 0, 10], small) == counted([0, 10, 0, 10])
    base = counted([-1, 1, -1, 1])[0]
    assert counted([-1, 1, -1, 1], factor=2.0)[0] == pytest.approx(8.0 * base)
    assert counted([4, 6, 4, 6], tensile=10.0)[0] == pytest.approx(8.0 * base), "Goodman: 1 / (1 - 5 / 10)"
    assert counted([-6, -4, -6, -4], tensile=10.0)[0] == pytest.approx(base), "no credit for compression"


def test_curves_and_steels_of_the_tables():
    """DNV-RP-C203, table 2-1: fatigue limit at 1e7 cycles; API RP 7G: 20 000 psi; a yield strength tells its grade."""
    limits = {"dnv_b1": 106.97, "dnv_c": 73.10, "dnv_d": 52.63, "dnv_f3": 32.75, "dnv_w3": 21.05}
    assert {name: round(1e-6 * CURVES[name][0], 2) for name in limits} == pytest.approx(limits, abs=0.011)
    knee, cycles, slope, _ = CURVES["dnv_high_strength"]
    assert cycles * (knee / 235e6) ** slope == pytest.approx(2e6, rel=5e-3), "2.4.10: 235 MPa at 2e6 cycles"
    law = rainflow.Law(*CURVES["api_rp_7g"], 1.0)
    damage = as_python(rainflow.damage_of)
    assert damage(law, -137e6, 137e6, 1.0, np.inf) == 0.0 < damage(law, -138e6, 138e6, 1.0, np.inf)
    assert steel_of(None) == GRADES["E75"]
    assert steel_of(930.79e6) == GRADES["S135"]
    assert steel_of(800e6).tensile_strength == 800e6


@pytest.fixture(scope="module")
def rolling():
    """A string that rolls on the wall, with and without a count."""
    return [Twin(quiet_scene(ROLLING, of=effects, radius=0.04, step=2e-3)) for effects in (STRESSED, WALLED)]


def test_the_count_does_not_act_and_survives_a_checkpoint(rolling, tmp_path):
    stressed, plain = rolling
    for _ in range(250):
        one, other = stressed.advance(TURNING, 0.01), plain.advance(TURNING, 0.01)
    np.testing.assert_array_equal(one.positions, other.positions)
    assert other.stress is None
    assert one.stress[0, CYCLES] > 1.0
    assert one.stress[0, DAMAGE] > 0.0
    Checkpoint.of(stressed, TURNING).save(tmp_path / "run.npz")
    resumed = Checkpoint.load(tmp_path / "run.npz").twin()
    for _ in range(100):
        one, other = stressed.advance(TURNING, 0.01), resumed.advance(TURNING, 0.01)
        np.testing.assert_array_equal(one.stress, other.stress)


@pytest.mark.slow
def test_yield_is_told_once():
    weak = FATIGUE | {"sections": [{"name": "weak", "distance_from_bit": 2.5}]}
    scene = quiet_scene(ROLLING, of=STRESSED | {"fatigue": weak}, radius=0.04, step=2e-3,
                        sections=({"yield_strength": 1e4},))  # fmt: skip
    loop = RunLoop(scene, 0.01, lambda *_: None)
    for _ in range(150):
        loop.advance(TURNING)
    (said,) = loop.missing_effects.found
    assert "the stress at weak reached" in said
    assert "above its yield strength of 0.01 MPa" in said


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("sections[0].distance_from_bit", "501 m", 'expected "collar" on the string (500 m long), found 501 m'),
        ("sections[2].measured_depth", "600 m", 'expected "pipe" on the string (500 m long), found 600 m'),
        ("sections[0].measured_depth", "3 m", "expected either `distance_from_bit` or `measured_depth`, found both"),
        ("sections[1].name", "collar", 'expected a name of its own, found "collar" again'),
        ("sections[2].grade", "S136", "expected one of E75, X95, G105, S135"),
        ("curve", "dnv_z", "dnv_b1"),
        ("smallest_range", "3 N", "expected a pressure"),
        ("line", {"stress_range": "200 MPa", "slope": 4}, "expected either `curve` or `line`, found both"),
    ],
)
def test_a_mistake_is_one_line(key, value, said):
    with pytest.raises(SceneError) as caught:
        load_scene("bha_stress", overrides={"effects.fatigue.curve": "dnv_c", f"effects.fatigue.{key}": value})
    (line,) = str(caught.value).splitlines()
    assert said in line
    assert f"effects.fatigue.{key.partition('[0].m')[0]}" in line
