# SPDX-License-Identifier: Apache-2.0
"""The search reads motions as a reader of spectra does, goes on where it was, and says what excludes what."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError
from drill_twin.scene import load_scene, parse_scene
from drill_twin_evidence.paper.runs.cases import Case, changed
from drill_twin_evidence.paper.search import search as module
from drill_twin_evidence.paper.search import space
from drill_twin_evidence.paper.search.assumptions import ASSUMPTIONS, LOOSE, STRICT, pair_misfits, score
from drill_twin_evidence.paper.search.evaluate import Bench, failed
from drill_twin_evidence.paper.search.exclusion import examined, exclusion_of, finalists_of, numbers_of
from drill_twin_evidence.paper.search.habits import HABITS, habits
from drill_twin_evidence.paper.search.readings import BASE, NUMBERS, TIMES, WHIRLS, Motion, misfits, read
from drill_twin_evidence.paper.search.record import Evaluated, Record
from drill_twin_evidence.paper.search.short_spectra import short_spectra
from drill_twin_evidence.paper.search.space import (
    FREE,
    SLIP,
    known_trials,
    mutated,
    random_trial,
    scene_of_trial,
    trial_of_scene,
)  # fmt: skip
from drill_twin_evidence.paper.search.text import habit_rows, value_rows

RADIUS, CLEARANCE = 8.25e-3, 81.75e-3
BENCH = "pa6_calibrated"
SECONDS = 3.0


def whirling(whirl: float, rotation: float = 2.0, radius: float = 0.05, begins: float = 3.0) -> Motion:
    """Motion of a string that whirls on a circle from some time on."""
    time = np.arange(1, 1201) / 40.0
    circle = np.where(time > begins, radius, 1e-5) * np.exp(2j * math.pi * whirl * time)
    centre = circle[:, None] * np.array([0.2, 0.6, 1.0])
    return Motion(time, centre, math.tau * rotation * time, RADIUS, CLEARANCE)


def reading(whirl: float, **how: float):
    """Readings of such a motion."""
    return read(whirling(whirl, **how))


def test_a_short_plain_spectrum_has_its_lowest_line_at_the_inverse_of_its_length(monkeypatch):
    """Whirls of 8/7 and 2/7 Hz; over 10 s the line nearest to 2/7 Hz is the third."""
    rates = {20.0: 8.0 / 7.0, 150.0: 2.0 / 7.0, 300.0: 2.0 / 7.0}
    monkeypatch.setattr(Bench, "motion", lambda _self, _one, case: whirling(rates[case.weight_on_bit], radius=0.07))
    bench = Bench(load_scene(BENCH))
    found = {one.reading: one for one in short_spectra(bench, trial_of_scene(bench.scene))}
    lowest, third = (found[f"x of mark_2, {length} after the onset"] for length in ("3.5 s", "10 s"))
    assert lowest.lines == pytest.approx((8.0 / 7.0, 2.0 / 7.0, 2.0 / 7.0), rel=0.01)
    assert third.lines == pytest.approx((1.1, 0.3, 0.3), rel=0.01)
    assert (lowest.first, third.first) == (True, False)
    assert "x of mark_2, 2.5 s after the onset" not in found


def test_an_interval_stands_in_place_of_an_irregular_whirl(monkeypatch):
    """A whirl that changes from 0.2 to 0.6 Hz within the last half: least and most over windows of 3 s."""
    slow, fast = whirling(0.2), whirling(0.6)
    changing = slow._replace(centre=np.where(slow.time[:, None] < 22.0, slow.centre, fast.centre))
    monkeypatch.setattr(Bench, "motion", lambda *_: changing)
    bench = Bench(load_scene(BENCH))
    one = trial_of_scene(bench.scene)
    results = {case: bench.run(one, case) for case in map(_case, range(len(NUMBERS)))}
    best = examined(bench, finalists_of([Evaluated(one, results)], STRICT)[0])
    value = best.values[4]
    assert value.irregular
    assert (value.low, value.high) == pytest.approx((0.2, 0.6), abs=0.01)
    assert f"irregular: {value.low:.2g} to {value.high:.2g} over windows" in str(
        [cells[-1] for cells in value_rows(SimpleNamespace(finalists=(best,)))]
    )


def test_a_whirl_is_read_in_each_way():
    found = reading(-1.3)
    by_name = dict(zip(WHIRLS, found.whirl, strict=True))
    assert by_name["precession of mark_2"] == pytest.approx(-1.3)
    assert by_name["highest line of mark_2, wall, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    # at mark_1 the string's surface turns on a wider circle than its centre line
    assert by_name["highest line of mark_1, wall, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    assert by_name["highest line of mark_1, centre, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    thin = dict(zip(WHIRLS, reading(1.3, radius=0.03).whirl, strict=True))
    assert thin["highest line of mark_1, wall, last half, every 25 ms"] == pytest.approx(2.0, abs=0.01)
    fast = dict(zip(WHIRLS, reading(5.0, rotation=6.0).whirl, strict=True))
    assert fast["highest line of mark_2, centre, last half, every 25 ms"] == pytest.approx(5.0, abs=0.01)
    assert fast["highest line of mark_2, centre, last half, every 150 ms"] == pytest.approx(1 / 0.15 - 5.0, abs=0.01)
    assert dict(zip(TIMES, found.time, strict=True))["5 % of the clearance, mark_2"] == pytest.approx(3.0, abs=0.05)
    assert found.size[2] == pytest.approx([0.05825, 0.05825, 0.05, 0.05], abs=5e-4)
    assert found.spread < 0.01


def test_two_numbers_are_met_in_one_reading_only():
    at_150, at_300 = (Case(load, 2.0) for load in (150.0, 300.0))
    line = WHIRLS.index("highest line of mark_1, wall, 30 s, every 25 ms")
    slow, fast = reading(0.28), reading(1.0)
    fast.whirl[line] = 0.29
    slow.whirl[line] = 2.0
    i, j = (k for k, number in enumerate(NUMBERS) if number.q in ("Q16", "Q17"))
    results = {at_150: slow, at_300: fast}
    table = pair_misfits(results, any_reading=True)
    assert table[i, i] == pytest.approx(0.0, abs=0.05)
    assert table[j, j] == pytest.approx(0.0, abs=0.05)
    assert table[i, j] > 3.0
    assert score(results, any_reading=True).met == 1
    fast.whirl[BASE["whirl"]] = 0.29
    assert pair_misfits(results, any_reading=False)[i, j] < 0.1
    assert np.isinf(pair_misfits(results, any_reading=True)[0, i])  # its run was not made
    assert (misfits({at_150: failed()})["whirl"][1] == 8.0).all()


def test_a_set_is_a_scene_and_a_scene_a_set(tmp_path):
    scene = Bench(load_scene(BENCH)).scene
    one = trial_of_scene(scene)
    again = scene_of_trial(scene, one)
    assert again.effects.wall_friction.coefficient == pytest.approx(scene.effects.wall_friction.coefficient, rel=1e-3)
    assert again.rig.weight_on_bit.duration == pytest.approx(scene.rig.weight_on_bit.duration, rel=1e-3)
    random = np.random.default_rng(3)
    drawn = [random_trial(random) for _ in range(40)]
    for k, choice in enumerate(space.CHOICES):
        assert {one.choices[k] for one in drawn} == set(range(len(choice.options))) or min(choice.chance) < 0.1
    with_play = next(one for one in drawn if one.choices[space.BIT] == 2)
    file = tmp_path / "with_play.yaml"
    file.write_text(scene_of_trial(scene, with_play).to_yaml(), "utf-8")
    assert load_scene(str(file)).effects.bit_stabiliser is not None
    kept = ASSUMPTIONS[STRICT].applied(drawn[0])
    assert ASSUMPTIONS[STRICT].hold(kept)
    assert not any(kept.choices)
    assert len(one.shares) == len(FREE)


def test_a_set_of_joined_friction_has_two_numbers_more():
    bench = Bench(load_scene(BENCH), joined=True)
    one = known_trials(bench.scene, joined=True)[0]
    law = scene_of_trial(bench.scene, one).effects.wall_friction
    assert (law.static_speed, law.dynamic_speed) == pytest.approx((0.1, 1.0), rel=1e-3)
    assert law.variant == "step"
    assert 0.0 < law.sliding < law.coefficient
    assert "fall of friction with slip" not in numbers_of(one)
    random = np.random.default_rng(4)
    drawn = random_trial(random, joined=True)
    assert len(drawn.shares) == len(one.shares) == len(FREE) + len(SLIP)
    assert any(mutated(random, one, drawn).shares[-2:] != one.shares[-2:] for _ in range(9))
    plain = random_trial(np.random.default_rng(4))
    assert (len(plain.shares), plain.shares) == (len(FREE), drawn.shares[: len(FREE)])


def test_a_habit_of_multibody_codes_is_a_change_of_the_bench():
    bench = Bench(load_scene(BENCH), SECONDS)
    one, changes = trial_of_scene(bench.scene), HABITS["integrator's damping at 5 ms and 1.1 Hz, as drag"]
    asked = []
    bench.run = lambda trial, case, own: asked.append((trial, case, own)) or failed()
    rows = list(habit_rows(habits(bench)))
    assert [cells[0] for cells in rows] == list(HABITS)
    assert (one, Case(300.0, 2.0), {"numerics.elements": 20, **changes}) in asked
    for name, own in HABITS.items():  # each is a change that a scene accepts
        scene = bench.scene
        for place, value in own.items():
            scene = changed(scene, place, value)
        assert parse_scene(scene.to_yaml()), name


def test_growth_along_the_ramps_gives_the_critical_times_of_runs():
    """For a load at the bit and straight ramps, and for one at the top, a STEP and a narrow hole."""
    bench = Bench(load_scene(BENCH), 9.0)
    sliding = trial_of_scene(bench.scene)
    other = sliding._replace(choices=(1, 1, 0, 0, 1, 1, 0))
    for one in (sliding, other):
        times = bench.grown_times(one)
        for k, load in enumerate((20.0, 40.0, 300.0)):
            run = bench.run(one, Case(load, 2.0))
            both = np.isfinite(run.time)
            assert both.sum() >= 4
            assert times[k][both] == pytest.approx(run.time[both], rel=0.03, abs=0.03)
    assert bench.grown_times(sliding._replace(choices=(0, 0, 1, 0, 0, 0, 0))) is None


@pytest.fixture
def small(monkeypatch):
    """A search of few and short runs, on the kernel that other tests compile."""
    monkeypatch.setattr(module, "TOGETHER", 9)
    monkeypatch.setattr(module, "PROPOSED", 4)
    plain = tuple(
        choice._replace(chance=(1.0, *(0.0 for _ in choice.options[1:]))) if k in (space.BIT, space.LAW) else choice
        for k, choice in enumerate(space.CHOICES)
    )
    monkeypatch.setattr(space, "CHOICES", plain)


def searched(file, sets, threads=1):
    bench = Bench(load_scene(BENCH), SECONDS)
    record = Record(file, {"seed": 5, "seconds": SECONDS, "scene": load_scene(BENCH).to_yaml()})
    archive = module.search(bench, record, sets=sets, seed=5, threads=threads)
    return bench, record, archive


@pytest.mark.usefixtures("small")
def test_a_search_goes_on_where_it_was_and_prints_what_excludes_what(tmp_path):
    whole, halves = tmp_path / "whole.jsonl", tmp_path / "halves.jsonl"
    bench, record, archive = searched(whole, 30, threads=2)
    assert record.sets >= 30
    searched(halves, 1)
    text = halves.read_bytes()
    halves.write_bytes(text + b"[4,[[[0.1")  # a line that was cut off
    _, again, _ = searched(halves, 30)
    assert halves.read_bytes() == whole.read_bytes()
    assert again.sets == record.sets
    with pytest.raises(ArgumentError, match="one of another seed"):
        Record(whole, {"seed": 6})

    found = exclusion_of(record, bench)
    assert np.array_equal(found.least, archive.least)
    assert (found.least[LOOSE] <= found.least[STRICT]).all()
    assert (found.least[1:LOOSE] <= found.least[STRICT]).all()
    (_, i, j), one = next(item for item in found.best.items() if item[0][0] == STRICT and item[0][1] != item[0][2])
    results = {case: bench.run(one, case) for case in (_case(i), _case(j))}
    assert pair_misfits(results, any_reading=False)[i, j] == pytest.approx(found.least[STRICT, i, j], abs=0.02)

    done = CliRunner().invoke(
        app,
        ["paper-search", "--record", str(whole), "--sets", "0", "--seed", "5", "--duration", str(SECONDS)],
        env={"COLUMNS": "200"},
    )
    assert done.exit_code == 0, done.output
    assert f"{record.sets} sets: {record.grown} by growth along the ramps" in done.output
    assert "Pairs of numbers that no set meets" in done.output
    data = json.loads((tmp_path / "exclusion.json").read_text())
    assert data["runs"] == sum(len(one.results) for one in record.evaluated)
    table = (tmp_path / "exclusion.csv").read_text().splitlines()
    assert len(table) == 1 + 105
    assert table[0].startswith("first,second,all kept,R may be the diameter")
    best = load_scene(str(tmp_path / "set_1.yaml"))
    assert best.effects.stretch is not None
    assert data["finalists"][0]["met"] == max(score(one.results, any_reading=True).met for one in record.evaluated)
    assert (tmp_path / "paper_exclusion.png").stat().st_size > 10_000


def _case(k):
    return Case(NUMBERS[k].weight_on_bit, NUMBERS[k].speed)
