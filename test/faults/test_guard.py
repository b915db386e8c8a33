# SPDX-License-Identifier: Apache-2.0
"""Faults put into the physics on purpose: the guard takes a frame back, halves the step and goes on, or stops well."""

import copy
import math

import numpy as np
import pytest
from poison import Poison, install, poisoned
from rod_scenes import WALLED, rod_scene
from summaries import summarise

from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import RunError, StoppedError
from drill_twin.dynamics.solver.state import HALVINGS
from drill_twin.dynamics.twin import frame_kernel, state_judge
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.frame_kernel import GOOD_FRAMES_BEFORE_GROWTH
from drill_twin.dynamics.twin.step_guard import MAX_RETRIES, StepGuard, Violation
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages import topics
from drill_twin.io.messages.decode import JointStateReader, read_pose_array
from drill_twin.io.messages.diagnostics import Level, decode_diagnostics
from drill_twin.runs import Session
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command

NAN, EVER = math.nan, math.inf
FRAME, STEP = 0.01, 5e-3
TURNING = Command(0.0, 1.0)
HARMLESS = (0.1, EVER, 0.0, 0.0)
DEADLY = (0.1, EVER, 0.0, NAN)


def scene() -> Scene:
    effects = {"drag": {"linear": 0.01}, "lateral_kick": {"velocity": 0.1, "shape": "hump"}}
    return rod_scene(effects=effects, elements=8, step=STEP, form="lateral")


def frames(dose: tuple[float, ...], count: int):
    with poisoned(*dose):
        twin = Twin(scene())
        return twin, [twin.advance(TURNING, FRAME) for _ in range(count)]


def test_a_run_in_which_nothing_happens_is_not_touched():
    twin, quiet = frames(HARMLESS, 60)
    assert all(frame.intervention is None and frame.stats.steps == 2 for frame in quiet)
    assert twin.checkpoint()["guard"].tolist() == [1.0, 0.0]


def test_a_fault_of_too_large_a_step_is_taken_back_and_done_with_a_smaller_one():
    """The poison acts in steps longer than 1 ms; three halvings are below that."""
    _, seen = frames((0.1, 0.2, 1e-3, 1e8), 60)
    told = [frame.intervention for frame in seen if frame.intervention]
    assert [(i.time, i.tries, i.kind) for i in told] == [(pytest.approx(0.1), 3, "speed")]
    assert told[0].step == pytest.approx(STEP / 8)
    assert "taken back and done again with a step of 0.000625 s" in told[0].text
    # the step grows back by doubling
    steps = [frame.stats.steps for frame in seen]
    assert steps == [2] * 10 + [16] * (1 + GOOD_FRAMES_BEFORE_GROWTH) + [8] * GOOD_FRAMES_BEFORE_GROWTH + [
        4
    ] * GOOD_FRAMES_BEFORE_GROWTH + [2] * (49 - 3 * GOOD_FRAMES_BEFORE_GROWTH)
    # what came out is the motion without the poison, computed finer for a while
    _, clean = frames(HARMLESS, 60)
    assert np.allclose(seen[-1].positions, clean[-1].positions, atol=1e-4)
    assert np.isfinite([frame.velocities for frame in seen]).all()


def test_a_frame_done_again_in_the_middle_of_a_block_is_that_of_single_frames():
    dose = (0.1, 0.2, 1e-3, 1e8)
    _, singles = frames(dose, 60)
    with poisoned(*dose):
        twin = Twin(scene())
        block, error = twin.fill(twin.record(60), np.tile(TURNING, (60, 1)), FRAME)
    assert error is None
    assert list(block.interventions) == [frame.intervention for frame in singles if frame.intervention]
    np.testing.assert_array_equal(block.positions, [frame.positions for frame in singles])
    assert block.stats.steps == sum(frame.stats.steps for frame in singles)


def test_a_step_that_newton_cannot_take_is_cut_within_the_frame_and_no_matter_for_the_guard():
    _, seen = frames((0.1, 0.2, 1e-3, NAN), 30)
    assert all(frame.intervention is None for frame in seen)
    assert sum(frame.stats.cut_steps for frame in seen) > 0
    assert np.isfinite([frame.velocities for frame in seen]).all()


def test_a_frame_that_grinds_is_given_up_in_a_bounded_time():
    """Steps beyond 1/3000 of the nominal one fail, so that every other one is cut: Newton's method goes on, nobody
    waits. The guard's smallest step is 1/64."""
    with poisoned(0.1, EVER, STEP / 3000, NAN):
        twin = Twin(scene())
        for _ in range(10):
            twin.advance(TURNING, FRAME)
        before = twin.checkpoint()["counters"][HALVINGS]
        with pytest.raises(StoppedError, match="cut more than 2400 times within a frame") as told:
            twin.advance(TURNING, FRAME)
        assert twin.checkpoint()["counters"][HALVINGS] == before  # taken back
    assert (told.value.kind, told.value.time) == ("newton", pytest.approx(0.1))
    assert "a step of 7.8e-05 s was cut more" in str(told.value)


@pytest.mark.parametrize(("push", "kind", "words"), [
    (NAN, "newton", "poison gives no number 1.25 m from the bit"),
    (1e12, "speed", "faster than any string can (1446 m/s)"),
])  # fmt: skip
def test_a_fault_that_stays_stops_the_run_at_the_last_good_frame(push, kind, words):
    with poisoned(0.1, EVER, 0.0, push):
        twin = Twin(scene())
        good = [twin.advance(TURNING, FRAME) for _ in range(10)][-1]
        with pytest.raises(StoppedError) as stopped:
            twin.advance(TURNING, FRAME)
    error = stopped.value
    assert (error.kind, error.time) == (kind, pytest.approx(0.1))
    assert 0 <= error.node <= 8
    assert words in str(error)
    assert f"down to {STEP / 2**MAX_RETRIES:.2g} s" in str(error)
    other = copy.copy(error)  # as pickle takes it from a worker to who asked for the run
    assert (str(other), other.kind, other.time, other.effect) == (str(error), kind, error.time, error.effect)
    assert twin.time == pytest.approx(0.1)
    assert np.array_equal(twin.unknowns[0][:, :3], good.positions)
    time, u, v = twin.last_second()
    assert time == pytest.approx(np.arange(1, 11) * FRAME)
    assert np.isfinite(u).all()
    assert np.array_equal(v[-1][:, :3], good.velocities)


def test_a_checkpoint_in_a_calm_after_an_intervention_goes_on_bit_for_bit():
    """How far the step has grown back is part of what a run remembers."""
    dose = (0.1, 0.105, 1e-3, 1e8)
    with poisoned(*dose):
        twin = Twin(scene())
        for _ in range(15):
            twin.advance(TURNING, FRAME)
        other = Twin(scene())
        other.restore(twin.checkpoint())
        for _ in range(30):
            one, two = twin.advance(TURNING, FRAME), other.advance(TURNING, FRAME)
            assert np.array_equal(one.positions, two.positions)
            assert one.stats.steps == two.stats.steps


@pytest.fixture
def session():
    install(Poison(*HARMLESS))
    yield lambda dose: (install(Poison(*dose)), Session(scene()))[1]
    from poison import remove

    remove()


def guard_reports(bag):
    messages = Bag(bag).messages((topics.DIAGNOSTICS,))
    return [status for *_, raw in messages for status in decode_diagnostics(raw)[1] if status.name == "simulator"]


def test_an_intervention_is_in_bag_diagnostics_and_summary(session, tmp_path):
    ready = session((0.1, 0.105, 1e-3, 1e8))
    outcome = ready.run(tmp_path / "bag_0")
    report = guard_reports(outcome.bag)
    assert report[-1].values["guard_interventions"] == "1"
    assert report[0].level is Level.WARN
    assert sum("taken back and done again" in status.values.get("guard", "") for status in report) == 1
    summary = summarise(outcome.bag)
    assert summary["guard"]["interventions"] == 1
    assert summary["guard"]["stopped"] is None
    assert "at 0.1 s" in summary["guard"]["events"][0]
    assert any("1 frames done again" in note or "1 frame done again" in note for note in summary["notes"])


def test_a_stop_leaves_a_readable_bag_a_checkpoint_and_the_last_second(session, tmp_path):
    ready = session((1.3, EVER, 0.0, NAN))
    with pytest.raises(RunError) as stopped:
        ready.run(tmp_path / "bag_0")
    bag = Bag(tmp_path / "bag_0")
    assert not bag.truncated
    states = [JointStateReader().read(raw) for _, _, raw in bag.messages((topics.RIG_STATE,))]
    assert len(states) == 130
    for _, _, raw in bag.messages((topics.STRING_POSES,)):
        poses = read_pose_array(raw)
        assert np.isfinite(poses.position).all()
        assert np.isfinite(poses.orientation).all()
    last = guard_reports(tmp_path / "bag_0")[-1]
    assert last.level is Level.ERROR
    assert "past t = 1.3 s" in last.values["guard_stop"]
    assert "poison gives no number" in last.values["guard_stop"]
    summary = summarise(tmp_path / "bag_0")
    assert "past t = 1.3 s" in summary["guard"]["stopped"]
    assert any("the run was stopped" in note for note in summary["notes"])
    folder = tmp_path / "bag_0_stop"
    assert str(folder) in str(stopped.value)
    assert "past t = 1.3 s" in (folder / "why.txt").read_text()
    with np.load(folder / "last_second.npz") as kept:
        assert kept["time"] == pytest.approx(np.arange(31, 131) * FRAME)
        assert kept["u"].shape == kept["v"].shape == (100, 9, 7)
        assert np.isfinite(kept["u"]).all()
    # the checkpoint is that of the last good frame, and a twin without the fault goes on from it
    install(Poison(*HARMLESS))
    twin = Checkpoint.load(folder / "checkpoint.npz").twin()
    assert twin.time == pytest.approx(1.3)
    assert np.isfinite(twin.advance(TURNING, FRAME).positions).all()


@pytest.mark.parametrize(
    ("kind", "tries"), [("fold", 1), ("slope", 1), ("speed", MAX_RETRIES), ("strain", MAX_RETRIES)]
)
def test_what_no_smaller_step_mends_is_tried_once(monkeypatch, kind, tries):
    asked = []

    def implausible(self):
        asked.append(self.fraction)
        return Violation(kind, 3, "it was so")

    with poisoned(*HARMLESS):
        twin = Twin(scene())
        twin.advance(TURNING, FRAME)
        monkeypatch.setattr(StepGuard, "implausible", implausible)
        monkeypatch.setattr(twin.dynamics, "run", lambda *_: frame_kernel.IMPLAUSIBLE)
        with pytest.raises(StoppedError, match="it was so"):
            twin.advance(TURNING, FRAME)
    assert asked == [0.5**k for k in range(tries + 1)]


def test_what_the_string_cannot_be_is_told():
    """Each bound, from a state made up to break it and from one just within it."""
    walled = rod_scene(effects=WALLED, elements=8, radius=0.04, weight_on_bit=40.0)
    twin = Twin(walled)
    guard, bound, (u, v) = twin._guard, twin.dynamics.bound, Twin(walled).unknowns
    twin.advance(Command(40.0, 0.0), STEP)
    find_extremes, judge = map(as_python, (state_judge.find_extremes, state_judge.judge))

    def verdict(a: np.ndarray, b: np.ndarray, depth: float, place: int) -> Violation | None:
        find_extremes(twin.rod.outer_radius, a, b, bound.now)
        deepest = np.array([depth, place])
        bad = judge(bound.bounds, bound.now, bound.before, deepest, 40.0, STEP, bound.verdict)
        return guard.implausible() if bad else None

    def found(depth: float = -1.0, place: int = 5, **changed: tuple[int, int, float]) -> tuple[str, int] | None:
        a, b = u.copy(), v.copy()
        for rows, name in ((a, "u"), (b, "v")):
            if name in changed:
                node, column, value = changed[name]
                rows[node, column] = value
        violation = verdict(a, b, depth, place)
        return (violation.kind, violation.node) if violation else None

    assert found() is None
    assert found(u=(3, 0, NAN)) == ("finite", 3)
    assert found(v=(4, 6, EVER)) == ("finite", 4)
    assert found(v=(2, 1, 1440.0)) is None
    soft = rod_scene(effects={}, elements=8, sections=({"youngs_modulus": 1e3},))
    assert (
        Twin(soft).dynamics.bound.bounds.speed == 1000.0
    )  # sound at a metre a second is no bound for what sinks in mud
    assert found(v=(2, 1, 1450.0)) == ("speed", 2)
    assert found(v=(2, 6, 1450.0 / 0.00825)) == ("speed", 2)
    assert found(u=(6, 5, 1.4)) is None
    assert found(u=(6, 5, 1.6)) == ("strain", 6)
    assert found(u=(6, 5, 0.4)) == ("strain", 6)
    assert found(u=(7, 5, -1.0)) == ("fold", 7)
    a, b = u.copy(), v.copy()
    for turn, kind in ((170.0, None), (173.0, "fold")):
        a[4, 3:6] = np.sin(np.radians(turn)), 0.0, np.cos(np.radians(turn))
        violation = verdict(a, b, -1.0, 5)
        assert (violation.kind if violation else None) == kind
    # 40 N press a helix with F^2 r / (4 EI) = 1.5 N/m on the wall, 28 um deep: ten times that, and a little
    assert found(depth=2.7e-4) is None
    assert found(depth=3.2e-4) == ("penetration", 3)
    assert found(depth=3.2e-4, v=(2, 1, 0.1)) is None  # an impact goes deeper


def test_a_random_force_may_press_the_string_into_the_wall():
    """Ten times what six times its rms of 100 N/m presses into 10 kN/m2, without load, weight and motion."""
    force = {"rms": 100.0, "correlation_time": 1.0, "correlation_length": 1.0}
    effects = {"wall": {"linear_stiffness": 1e4}, "random_force": force}
    bounds = Twin(rod_scene(effects=effects, elements=8, radius=0.04)).dynamics.bound.bounds
    assert as_python(state_judge.largest_depth)(bounds, 0.0, 0.0, STEP) == pytest.approx(10.0 * 0.06)
