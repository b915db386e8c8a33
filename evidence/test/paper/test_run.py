# SPDX-License-Identifier: Apache-2.0
"""A run is measured rightly, and the same run gives the same numbers to the last bit."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drill_twin.scene import load_scene
from drill_twin_evidence.paper.runs.cases import Case, scene_of
from drill_twin_evidence.paper.runs.disorder import largest_lyapunov, spectral_entropy
from drill_twin_evidence.paper.runs.full_size import NEAR_BIT, REFERENCE, rows, steady_from
from drill_twin_evidence.paper.runs.run import measure, run, runs_of, x_spectrum


@pytest.fixture(scope="module")
def hard_push(quick_bench):
    return run(scene_of(quick_bench, Case(300.0, 2.0)))


def test_the_same_run_has_the_same_bits_and_one_thread_those_of_two(quick_bench, hard_push):
    scenes = {case: scene_of(quick_bench, case) for case in (Case(300.0, 2.0), Case(20.0, 2.0))}
    found = dict(runs_of(run, scenes, 2))
    again = found[Case(300.0, 2.0)]
    for name in ("time", "point", "velocity", "centre", "spin_rate"):
        assert (getattr(again, name) == getattr(hard_push, name)).all()
    assert measure(again) == measure(hard_push)
    assert measure(found[Case(20.0, 2.0)]) != measure(hard_push)


def test_a_run_holds_what_its_measures_say(hard_push):
    found = measure(hard_push)
    assert 0.0 < found.onset_s < 1.2
    assert hard_push.time.size == 120
    assert hard_push.period == 0.01
    offset = np.hypot(*(hard_push.point - hard_push.centre)[:, hard_push.index("mark_2"), :2].T)
    assert offset == pytest.approx(8.25e-3, rel=0.1)  # the mark is on the wall of a rod that leans a little
    for mark, largest in found.largest_mm.items():
        assert largest == pytest.approx(1e3 * np.abs(hard_push.point[:, hard_push.index(mark), :2]).max())
    centre = hard_push.centre[:, hard_push.index("mark_4"), :2]  # mark_4 is on the centre line
    assert found.largest_mm["mark_4"] == 1e3 * np.abs(centre).max()


def test_the_spectrum_of_a_mark_has_its_line_where_it_whirls(hard_push):
    time = np.arange(1, 1001) * 0.01
    x = 0.05 * np.cos(2.0 * math.pi * 1.13 * time)
    point = np.zeros((1000, 4, 3))
    point[:, hard_push.index("mark_2"), 0] = 0.02 + x
    circling = replace(hard_push, time=time, point=point, summary=replace(hard_push.summary, onset=None))
    frequency, height = x_spectrum(circling, "mark_2")
    assert frequency[np.argmax(height)] == pytest.approx(1.13, abs=0.02)
    assert height.max() == pytest.approx(0.05, rel=0.02)
    assert measure(circling).line_hz == pytest.approx(1.13, abs=0.02)
    too_short = replace(circling, time=time[:150], point=point[:150])
    assert measure(too_short).line_hz is None


def test_a_run_that_fails_keeps_what_came_before(quick_bench):
    done = run(scene_of(quick_bench, Case(2e4, 2.0)))
    assert 0 < done.time.size < 120
    assert len(done.point) == done.time.size
    assert "could not be followed" in done.failure
    assert measure(done).failure == done.failure


def test_entropy_is_that_of_a_circle_and_of_noise():
    time = np.arange(600) * 0.01
    random = np.random.default_rng(3)
    circle = np.exp(2j * math.pi * 1.5 * time)
    noise = random.normal(size=600) + 1j * random.normal(size=600)
    assert spectral_entropy(time, circle) < 0.3
    assert spectral_entropy(time, noise) > 0.85
    assert 0.3 < spectral_entropy(time, circle + 0.5 * noise) < 0.95


def test_neighbouring_runs_close_up_below_the_buckling_load():
    changes = {"effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "8", "wob": "0.5 N",
               "rpm": "6", "effects.drag.linear": "1 N s/m^2"}  # fmt: skip
    scene = load_scene("pa6_bench", overrides=changes)
    # the slowest decay of drag c on mass m is c / 2 m = 2.1 1/s, and slower where drag overdamps a mode
    assert -2.5 < largest_lyapunov(scene, 0.5, 1.5) < 0.0


def test_full_size_rows_read_ranges_off_the_right_spans(hard_push):
    time = np.arange(1, 501) * 0.01
    rate = np.where(time < 1.0, 1.0, 5.2)[:, None] * np.ones((1, 2))
    velocity = np.zeros((500, 2, 3))
    onset = replace(hard_push.summary.onset, time_s=3.0)
    velocity[:, 0, 0] = np.where(time < 3.0, 0.4, -1.1)
    summary = replace(hard_push.summary, onset=onset, rotation_rev_s=5.236 / math.tau)
    made = replace(hard_push, time=time, velocity=velocity, spin_rate=rate, names=(NEAR_BIT, "far_bit"),
                   point=velocity, centre=velocity, summary=summary)  # fmt: skip
    assert steady_from(made) == pytest.approx(1.0)
    found = {row.number.what: row for row in rows({REFERENCE: made})}
    assert found["near-bit velocity before whirl"].ours == (0.0, 0.4)
    assert found["near-bit velocity in whirl"].ours == (-1.1, 0.0)
    assert found["lateral vibration from"].ours == (3.0, 3.0)
    assert found["lateral vibration from"].near
    assert not found["near-bit velocity in whirl"].near
    assert found["near-bit displacement at 100 kN"].ours is None
