# SPDX-License-Identifier: Apache-2.0
"""The stream as it comes: the same samples give the same bits, and bad samples change nothing but their count."""

import gc
import tracemalloc
from dataclasses import fields, replace

import numpy as np
import pytest
from kinematics import MARKS, clock, growth, motion, play, play_each

from drill_twin import analyze
from drill_twin.whirl import Analyzer, Findings, MotionState


def moved_marks(rate=100, seconds=14.0, **how):
    whirl = growth(6.0, 0.05, 1.5, 0.5)
    return motion(clock(rate, seconds, jitter=0.1), bow=0.04, whirl=whirl, marks=MARKS, **how).with_noise(0.01, 1)


def bits(findings, *, but=()):
    values = []
    for field in fields(Findings):
        value = getattr(findings, field.name)
        if field.name not in but:
            values.append(value.tobytes() if isinstance(value, np.ndarray) else repr(value))
    return values


@pytest.mark.parametrize("spin", [True, False])
def test_live_and_offline_are_equal_to_the_last_bit(spin):
    moved = moved_marks()
    live, found = play_each(moved, spin=spin)
    offline = Analyzer(MARKS)
    whole = np.asfortranarray(moved.positions)  # other strides, other alignment
    twice = np.repeat(moved.spin, 2, axis=1)[:, ::2]
    for i, stamp in enumerate(moved.stamps.tolist()):
        again = offline.push(stamp, whole[i], twice[i] if spin else None, float(moved.top_speed[i]))
        assert bits(again) == bits(found[i])
    assert offline.summary() == live.summary()
    assert offline.summary().onset is not None


@pytest.mark.parametrize("kind", [int, np.float32])
def test_a_mark_given_in_other_types_of_numbers_is_the_same_mark(kind):
    """The analysis is compiled once, for the types of its own arrays."""
    moved = moved_marks(seconds=10.0)
    found = []
    for number, inclined in ((float, False), (kind, 0)):
        marks = [replace(m, clearance=number(1), wall_offset=number(0), inclined=inclined) for m in MARKS]
        analyzer = Analyzer(marks)
        for i, stamp in enumerate(moved.stamps.tolist()):
            findings = analyzer.push(stamp, moved.positions[i], moved.spin[i], float(moved.top_speed[i]))
        found.append(findings.orbit_radius)
    assert found[0].any()
    np.testing.assert_array_equal(*found)


def test_findings_are_not_overwritten_by_later_samples():
    moved = moved_marks(seconds=10.0)
    analyzer, positions, kept = Analyzer(MARKS), moved.positions, []
    for i, stamp in enumerate(moved.stamps.tolist()):
        findings = analyzer.push(stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
        kept.append((findings, bits(findings)))
    assert all(bits(findings) == then for findings, then in kept)


def test_duplicate_late_and_incomplete_samples_are_counted_and_skipped():
    moved = moved_marks()
    clean, found = play_each(moved)
    dirty, positions = Analyzer(MARKS), moved.positions
    stamps = moved.stamps.tolist()
    nothing = np.full_like(positions[0], np.nan)
    for i, stamp in enumerate(stamps):
        args = (positions[i], moved.spin[i], float(moved.top_speed[i]))
        findings = dirty.push(stamp, *args)
        assert bits(findings, but=("quality",)) == bits(found[i], but=("quality",))
        if i % 10 == 3:
            dirty.push(stamp, *args)
        if i % 10 == 5:
            skipped = dirty.push(stamps[i - 4], positions[i - 4], *args[1:])
            assert bits(skipped, but=("quality",)) == bits(findings, but=("quality",))
        if i % 10 == 7:
            dirty.push(stamp + 1, nothing, *args[1:])
        if i % 10 == 8:
            dirty.push(stamp + 1, args[0], None, args[2])
    n = len(stamps) // 10
    quality = dirty.summary().quality
    assert (quality.duplicate, quality.late, quality.incomplete) == (n, n, 2 * n)
    assert quality.accepted == len(stamps) == clean.quality.accepted
    assert dirty.summary().onset == clean.summary().onset
    notes = " ".join(dirty.summary().notes)
    assert f"{n} duplicate" in notes
    assert f"{n} samples from before" in notes
    assert f"{2 * n} incomplete" in notes


def test_shuffled_neighbours_still_give_the_onset():
    moved = moved_marks()
    order = np.arange(moved.time.size)
    order[10:-10:20], order[11:-9:20] = order[11:-9:20].copy(), order[10:-10:20].copy()
    analyzer, _ = play(moved.keep(order))
    assert analyzer.quality.late > 50
    assert analyzer.summary().onset.time_s == pytest.approx(moved.true_onset(2), abs=0.25)


def test_one_mark_missing_leaves_the_others_alone():
    moved = moved_marks()
    _, found = play_each(moved)
    analyzer, positions = Analyzer(MARKS), moved.positions
    for i, stamp in enumerate(moved.stamps.tolist()):
        positions[i, 1] = np.nan
        findings = analyzer.push(stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
        others = [0, 2, 3]
        assert np.array_equal(findings.precession[others], found[i].precession[others], equal_nan=True)
        assert np.array_equal(findings.orbit_radius[others], found[i].orbit_radius[others], equal_nan=True)
        assert np.isnan(findings.precession[1])
        assert np.isnan(findings.orbit_radius[1])
        assert findings.confidence[1] == 0.0
    summary = analyzer.summary()
    assert summary.max_radius_m["mark_2"] is None
    assert summary.onset is not None
    assert summary.quality.missing_marks == moved.time.size


def test_marks_that_drop_out_for_a_while():
    moved = moved_marks()
    positions = moved.positions
    random = np.random.default_rng(3)
    positions[random.uniform(size=positions.shape[:2]) < 0.2] = np.nan
    analyzer = Analyzer(MARKS)
    for i, stamp in enumerate(moved.stamps.tolist()):
        analyzer.push(stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
    summary = analyzer.summary()
    assert summary.onset.time_s == pytest.approx(moved.true_onset(2), abs=0.25)
    assert summary.whirl_ratio == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("gap", [(3.0, 4.5), (8.0, 9.2)])
def test_gap_in_the_stream(gap):
    moved = moved_marks()
    kept = moved.keep((moved.time < gap[0]) | (moved.time > gap[1]))
    analyzer, _ = play(kept)
    summary = analyzer.summary()
    assert summary.quality.gaps == 1
    assert any("gap" in note for note in summary.notes)
    assert summary.onset.time_s == pytest.approx(moved.true_onset(2), abs=0.25)
    assert summary.whirl_ratio == pytest.approx(0.5, rel=0.02)


def test_outliers_beyond_the_hole_are_left_out():
    moved = moved_marks()
    positions = moved.positions
    positions[::50, 2, 0] += 5.0
    analyzer = Analyzer(MARKS)
    for i, stamp in enumerate(moved.stamps.tolist()):
        analyzer.push(stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
    summary = analyzer.summary()
    assert summary.quality.missing_marks == len(positions[::50])
    assert summary.max_radius_m["mark_3"] < 1.2 * MARKS[2].clearance
    assert summary.onset.time_s == pytest.approx(moved.true_onset(2), abs=0.25)


def test_stamps_of_a_wall_clock():
    moved = moved_marks()
    start = 1_700_000_000_123_456_789
    analyzer, positions = Analyzer(MARKS), moved.positions
    for i, stamp in enumerate(moved.stamps.tolist()):
        findings = analyzer.push(start + stamp, positions[i], moved.spin[i], float(moved.top_speed[i]))
    here, _ = play(moved)
    shift = analyzer.summary().onset.time_s - start * 1e-9
    assert shift == pytest.approx(here.summary().onset.time_s, abs=1e-6)
    assert findings.ratio.tobytes() == here.findings.ratio.tobytes()


@pytest.mark.long
def test_memory_does_not_grow():
    moved = moved_marks(seconds=200.0)
    analyzer, positions = Analyzer(MARKS), moved.positions
    stamps, speeds = moved.stamps.tolist(), moved.top_speed.tolist()

    def push(first, last):
        for i in range(first, last):
            analyzer.push(stamps[i], positions[i], moved.spin[i], speeds[i])

    push(0, 8000)
    gc.collect()  # what compiling left must not be collected, or not, in between
    tracemalloc.start()
    push(8000, 8100)
    before = tracemalloc.get_traced_memory()[0]
    push(8100, 20000)
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 40_000


def test_reset_forgets():
    moved = moved_marks(seconds=8.0)
    analyzer, found = play(moved)
    analyzer.reset()
    assert analyzer.summary().quality.accepted == 0
    _, again = play(moved, analyzer)
    assert bits(again[-1]) == bits(found[-1])


@pytest.mark.parametrize("end", [14.0, 40.0])
def test_time_without_a_mark_is_not_observable_from_its_begin(end):
    time = np.arange(0.0, 40.0, 0.01)
    z = np.where((time < 10.0) | (time >= end), 0.054 * np.exp(-7.52j * np.pi * time), np.nan)
    found = analyze(time, z.real, z.imag, rotation=4.0 * np.pi, clearance=0.054, radius=0.1016).summary
    hidden = [period for period in found.motion if period.state is MotionState.NOT_OBSERVABLE]
    assert [period.start_s for period in hidden] == [pytest.approx(10.0, abs=0.1)]
    after = found.motion[found.motion.index(hidden[0]) + 1 :]
    assert [round(period.start_s) for period in after] == ([14] if end < 40.0 else [])
    assert found.whirl_frequency_hz == pytest.approx(-3.76, abs=0.01)
