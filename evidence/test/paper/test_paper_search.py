# SPDX-License-Identifier: Apache-2.0
"""The search reads motions as a reader of spectra does, goes on where it was, and says what excludes what."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from drill_twin.api import load_scene, override
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search import search as module
from drill_twin_evidence.paper.search import space
from drill_twin_evidence.paper.search.bench import Bench
from drill_twin_evidence.paper.search.exclusion import exclusion_of, finalists_of, score, tables
from drill_twin_evidence.paper.search.goals import ASSUMPTIONS, LOOSE, PAIRS, STRICT, Evaluated, pair_misfits
from drill_twin_evidence.paper.search.habits import CASES, HABITS, habit_table, habits
from drill_twin_evidence.paper.search.readings import BASE, NUMBERS, Motion, failed, misfits, read
from drill_twin_evidence.paper.search.space import FREE, SLIP, mutated, random_set, set_of

RADIUS, CLEARANCE = 8.25e-3, 81.75e-3
BENCH = "pa6_calibrated"
SECONDS = 3.0
LINES = tuple(Case(load, 2.0) for load in (150.0, 300.0))


def whirling(whirl: float, rotation: float = 2.0, radius: float = 0.05, begins: float = 3.0) -> Motion:
    """Motion of a string that whirls on a circle from some time on."""
    time = np.arange(1, 1201) / 40.0
    circle = np.where(time > begins, radius, 1e-5) * np.exp(2j * math.pi * whirl * time)
    centre = circle[:, None] * np.array([0.2, 0.6, 1.0])
    return Motion(time, centre, math.tau * rotation * time, RADIUS, CLEARANCE)


def reading(whirl: float, case: Case = LINES[0], **how: float):
    """Readings of such a motion."""
    return read(case, whirling(whirl, **how))


def moving(monkeypatch, motion_of) -> Bench:
    """A bench whose motion is a function of the case."""
    monkeypatch.setattr(Bench, "motions", lambda _self, wanted, _changes=None: [motion_of(case) for _, case in wanted])
    return Bench(load_scene(BENCH))


def evaluated(bench: Bench) -> Evaluated:
    """The bench as calibrated, with all its runs."""
    one = set_of(bench.scene)
    return Evaluated(list(one.fractions), list(one.choices), bench.run([(one, case) for case in module.ORDER]))


def test_an_interval_stands_in_place_of_an_irregular_whirl(monkeypatch):
    """A whirl that changes from 0.2 to 0.6 Hz within the last half: least and most over windows of 3 s."""
    slow, fast = whirling(0.2), whirling(0.6)
    changing = slow._replace(centre=np.where(slow.time[:, None] < 22.0, slow.centre, fast.centre))
    bench = moving(monkeypatch, lambda _case: changing)
    (best,) = finalists_of(bench, [evaluated(bench)], STRICT)
    value = best.values[4]
    assert (value.low, value.high) == pytest.approx((0.2, 0.6), abs=0.01)
    assert best.steady < best.met
    one = set_of(bench.scene)
    own = Evaluated(list(one.fractions), list(one.choices), evaluated(bench).runs)
    shown = next(table for table in tables(exclusion_of([own], bench)) if table.title == "Numbers of set 1")
    assert f"irregular: {value.low:.2g} to {value.high:.2g} over windows" in [cells[-1] for cells in shown.rows]


def test_a_whirl_is_read_in_each_way():
    found = reading(-1.3)
    assert found.whirl["precession of mark_2"] == pytest.approx(-1.3)
    assert found.whirl["highest line of mark_2, wall, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    # at mark_1 the string's surface turns on a wider circle than its centre line
    assert found.whirl["highest line of mark_1, wall, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    assert found.whirl["highest line of mark_1, centre, last half, every 25 ms"] == pytest.approx(1.3, abs=0.01)
    thin = reading(1.3, radius=0.03).whirl
    assert thin["highest line of mark_1, wall, last half, every 25 ms"] == pytest.approx(2.0, abs=0.01)
    fast = reading(5.0, rotation=6.0).whirl
    assert fast["highest line of mark_2, centre, last half, every 25 ms"] == pytest.approx(5.0, abs=0.01)
    assert fast["highest line of mark_2, centre, last half, every 150 ms"] == pytest.approx(1 / 0.15 - 5.0, abs=0.01)
    assert found.time["5 % of the clearance, mark_2"] == pytest.approx(3.0, abs=0.05)
    assert list(found.size["mark_3"].values()) == pytest.approx([0.05825, 0.05825, 0.05, 0.05], abs=5e-4)
    assert found.spread < 0.01
    assert [len(names) for names in (found.time, found.whirl, found.size["mark_1"])] == [6, 27, 4]
    assert BASE["time"] in found.time
    assert BASE["whirl"] in found.whirl
    assert BASE["size"] in found.size["mark_1"]


def test_two_numbers_are_met_in_one_reading_only():
    line = "highest line of mark_1, wall, 30 s, every 25 ms"
    slow, fast = reading(0.28), reading(1.0, LINES[1])
    fast.whirl[line] = 0.29
    slow.whirl[line] = 2.0
    i, j = (k for k, number in enumerate(NUMBERS) if number.q in ("Q16", "Q17"))
    results = dict(zip(LINES, (slow, fast), strict=True))
    table = pair_misfits(results, any_reading=True)
    assert table[i, i] == pytest.approx(0.0, abs=0.05)
    assert table[j, j] == pytest.approx(0.0, abs=0.05)
    assert table[i, j] > 3.0
    assert score(results, any_reading=True)[0] == 1
    fast.whirl[BASE["whirl"]] = 0.29
    assert pair_misfits(results, any_reading=False)[i, j] < 0.1
    assert np.isinf(pair_misfits(results, any_reading=True)[0, i])  # its run was not made
    assert (misfits({LINES[0]: failed(LINES[0])}, "whirl", any_reading=True)[1] == 8.0).all()


def test_a_set_is_a_scene_and_a_scene_a_set():
    scene = load_scene(BENCH)
    one = set_of(scene)
    again = override(scene, one.keys())
    assert again.effects.wall_friction.coefficient == pytest.approx(scene.effects.wall_friction.coefficient, rel=1e-3)
    assert again.rig.weight_on_bit.duration == pytest.approx(scene.rig.weight_on_bit.duration, rel=1e-3)
    random = np.random.default_rng(3)
    drawn = [random_set(random) for _ in range(40)]
    for k, choice in enumerate(space.CHOICES):
        assert {one.choices[k] for one in drawn} == set(range(len(choice.options))) or min(choice.chance) < 0.1
    with_play = next(one for one in drawn if one.choices[space.BIT] == 2)
    assert override(scene, with_play.keys()).effects.bit_stabiliser is not None
    kept = ASSUMPTIONS[STRICT].applied(drawn[0])
    assert ASSUMPTIONS[STRICT].hold(kept)
    assert not any(kept.choices)
    assert len(one.fractions) == len(FREE)
    with pytest.raises(SceneError, match=r"expected `effects\.bow`, whose bow is varied, found none"):
        set_of(override(scene, {"effects.bow": "off"}))


def test_a_set_of_joined_friction_has_two_numbers_more():
    scene = load_scene(BENCH)
    one = set_of(scene, joined=True)
    law = override(scene, one.keys()).effects.wall_friction
    assert (law.static_speed, law.dynamic_speed) == pytest.approx((0.1, 1.0), rel=1e-3)
    assert law.variant == "step"
    assert 0.0 < law.sliding < law.coefficient
    assert "fall of friction with slip" not in one.described()
    random = np.random.default_rng(4)
    drawn = random_set(random, joined=True)
    assert len(drawn.fractions) == len(one.fractions) == len(FREE) + len(SLIP)
    assert any(mutated(random, one, drawn).fractions[-2:] != one.fractions[-2:] for _ in range(9))
    plain = random_set(np.random.default_rng(4))
    assert (len(plain.fractions), plain.fractions) == (len(FREE), drawn.fractions[: len(FREE)])


def test_a_habit_of_multibody_codes_is_a_change_of_the_bench(monkeypatch):
    bench, asked = Bench(load_scene(BENCH), SECONDS), []
    monkeypatch.setattr(
        Bench, "run", lambda _self, wanted, own: asked.append((wanted, own)) or [failed(case) for _, case in wanted]
    )
    assert [cells[0] for cells in habit_table(habits(bench)).rows] == list(HABITS)
    drag = HABITS["integrator's damping at 5 ms and 1.1 Hz, as drag"]
    one = set_of(bench.scene)
    assert ([(one, case) for case in CASES], {"numerics.elements": 20, **drag}) in asked
    for name, own in HABITS.items():  # each is a change that a scene accepts
        assert override(bench.scene, own).name == bench.scene.name, name


@pytest.fixture
def small(monkeypatch):
    """A search of few and short runs, on the kernel that other tests compile."""
    monkeypatch.setattr(module, "TOGETHER", 9)
    plain = tuple(
        choice._replace(chance=(1.0, *(0.0 for _ in choice.options[1:]))) if k in (space.BIT, space.LAW) else choice
        for k, choice in enumerate(space.CHOICES)
    )
    monkeypatch.setattr(space, "CHOICES", plain)


def searched(file, sets, workers=1):
    bench = Bench(load_scene(BENCH), SECONDS, workers=workers)
    setup = {"seed": 5, "seconds": SECONDS, "scene": load_scene(BENCH).to_yaml(), "friction": "falling"}
    record = module.open_record(file, setup)
    archive = module.search(bench, record, sets=sets, seed=5)
    return bench, record, archive


@pytest.mark.usefixtures("small")
def test_a_search_goes_on_where_it_was_and_prints_what_excludes_what(tmp_path):
    whole, halves = tmp_path / "whole.jsonl", tmp_path / "halves.jsonl"
    bench, record, archive = searched(whole, 30, workers=2)
    assert len(module.evaluated(record)) >= 30
    searched(halves, 1)
    halves.write_bytes(halves.read_bytes() + b'[{"fractions":[0.1')  # a line that was cut off
    _, again, _ = searched(halves, 30)
    assert halves.read_bytes() == whole.read_bytes()
    assert len(module.evaluated(again)) == len(module.evaluated(record))
    with pytest.raises(ArgumentError, match="those of another seed"):
        module.open_record(whole, {"seed": 6})

    sets = module.evaluated(record)
    found = exclusion_of(sets, bench)
    assert np.array_equal(found.least, archive.least)
    assert (found.least[LOOSE] <= found.least[STRICT]).all()
    assert (found.least[1:LOOSE] <= found.least[STRICT]).all()
    (_, i, j), one = next(item for item in archive.best.items() if item[0][0] == STRICT and item[0][1] != item[0][2])
    cases = list(dict.fromkeys(Case(NUMBERS[k].weight_on_bit, NUMBERS[k].speed) for k in (i, j)))
    results = dict(zip(cases, bench.run([(one, case) for case in cases]), strict=True))
    assert pair_misfits(results, any_reading=False)[i, j] == pytest.approx(found.least[STRICT, i, j], abs=0.02)

    done = CliRunner().invoke(
        app,
        ["study", "paper-search", "--record", str(whole), "--sets", "0", "--seed", "5", "--duration", str(SECONDS)],
        env={"COLUMNS": "200"},
    )
    assert done.exit_code == 0, done.output
    assert f"{len(sets)} sets by {found.runs} runs" in done.output
    assert "Pairs of numbers that no set meets" in done.output
    data = json.loads((tmp_path / "exclusion.json").read_text())
    assert data["runs"] == sum(len(one.runs) for one in sets)
    table = (tmp_path / "exclusion.csv").read_text().splitlines()
    assert len(table) == 1 + 105
    assert table[0].startswith("first,second,all kept,R may be the diameter")
    best = load_scene(str(tmp_path / "set_1.yaml"))
    assert best.effects.stretch is not None
    assert data["finalists"][0]["met"] == max(score(one.results, any_reading=True)[0] for one in sets)
    assert (tmp_path / "paper_exclusion.png").stat().st_size > 10_000


def test_habits_need_no_search(tmp_path, monkeypatch):
    monkeypatch.setattr(Bench, "run", lambda _self, wanted, _own: [failed(case) for _, case in wanted])
    words = ["study", "paper-search", "--record", str(tmp_path / "new.jsonl"), "--sets", "0", "--habits"]
    done = CliRunner().invoke(app, words, env={"COLUMNS": "200"})
    assert done.exit_code == 0, done.output
    assert "0 sets by 0 runs" in done.output
    assert all(name in done.output for name in HABITS)


def test_the_page_has_the_counts_of_the_record_of_the_search():
    docs = Path(__file__).parents[2] / "docs"
    page = (docs / "paper_search.md").read_text("utf-8")
    with (docs / "paper_exclusion.csv").open(encoding="utf-8") as stream:
        pairs = list(csv.DictReader(stream))
    least = {one.name: np.array([float(pair[one.name]) for pair in pairs]) for one in ASSUMPTIONS}
    strict, loose = (least[ASSUMPTIONS[k].name] > 1.0 for k in (STRICT, LOOSE))
    assert (
        f"{strict.sum()} of {len(pairs)} pairs were met by no set; with any choice and any reading,\n{loose.sum()}"
        in page
    )
    for one in ASSUMPTIONS[1:LOOSE]:
        assert f"| {one.name} | {(strict & (least[one.name] <= 1.0)).sum()} |" in page
    for pair, excluded in zip(pairs, loose, strict=True):
        assert not excluded or f"| {float(pair['all kept']):.2f} | {float(pair['none kept']):.2f} |" in page


def test_the_page_has_the_counts_of_the_search_by_runs_alone():
    root = Path(__file__).parents[3]
    page = (root / "evidence" / "docs" / "paper_search.md").read_text("utf-8").partition("## The search repeated")[2]
    data = json.loads((root / "evidence" / "pages" / "paper_search.json").read_text("utf-8"))
    least = np.array(list(data["least"].values()), float)[:, *np.array(PAIRS).T]
    strict, opened = least[STRICT] > 1.0, [int((row[least[STRICT] > 1.0] <= 1.0).sum()) for row in least]
    assert f"{data['sets']} sets by {data['runs']} runs" in page
    assert f"| pairs met by no set, all kept | 35 | {strict.sum()} |" in page
    assert f"| pairs met by no set, none kept | 4 | {(least[LOOSE] > 1.0).sum()} |" in page
    assert f"R as the diameter alone | 26 | {opened[1]} |" in page
    assert f"any reading alone | 13 | {opened[7]} |" in page
    assert opened[2:7] == [0] * 5
    for under, words in ((STRICT, "all"), (LOOSE, "none")):
        most = max(one["met"] for one in data["finalists"] if one["under"] == ASSUMPTIONS[under].name)
        assert f"met by one set, {words} kept | {10 + (under == LOOSE)} | {most} |" in page
