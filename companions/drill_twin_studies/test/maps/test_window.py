# SPDX-License-Identifier: Apache-2.0
"""Windows hold only what is known to stay calm: on maps whose truth is known in closed form, and on runs that grow."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from coarse_map import COARSE

import drill_twin as dt
from drill_twin.core.errors import ArgumentError
from drill_twin.runs.ensemble import Threads
from drill_twin_studies.api.maps import check
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span
from drill_twin_studies.maps.drawing import shown as shown_of
from drill_twin_studies.maps.fields import MARGIN
from drill_twin_studies.maps.grounds import ROUNDS
from drill_twin_studies.maps.plane import known_and_calm, rectangles
from drill_twin_studies.maps.proportions import none_of
from drill_twin_studies.maps.regimes import TorsionalSpeeds
from drill_twin_studies.maps.runs import FINER, Key, Runner, RunRecord, Trend
from drill_twin_studies.maps.search import BoundarySearch

STEPS = 32
PLANE = Plane(Span(0.0, 320.0), Span(0.0, 32.0), STEPS)  # a step is 10 N and 1 rad/s


def made(regime_at, *, every=1, growth=(), extra=(), draws=()):
    """Map with a run at each `every`-th node."""
    nodes = [(i, j) for i in range(0, STEPS + 1, every) for j in range(0, STEPS + 1, every)]
    records = {Key(i, j): RunRecord(regime_at(i, j)) for i, j in nodes} | dict(extra)
    return OperatingMap("string", "", "", PLANE, 30.0, draws, records, growth=growth, asked=300.0)


def triangle(i, j):
    """Calm below a diagonal."""
    return Regime.SMOOTH if i + j < STEPS else Regime.FORWARD


def share_in(found):
    """Share of the ranges in windows."""
    return found.window_cells.mean()


def test_windows_fill_a_triangle_by_steps_and_stay_inside():
    found = made(triangle)
    cells = np.argwhere(found.window_cells)
    assert (cells.sum(axis=1) + 2 < STEPS * (1.0 - MARGIN)).all()  # the far corners of the cells, with the margin
    assert len(found.windows) == 3
    assert 0.6 * 0.5 < share_in(found) < 0.5  # of a triangle one rectangle has at most a half
    assert found.window == found.windows[0]


def test_a_line_of_zero_growth_bounds_them():
    rates = np.add.outer(np.linspace(-1.0, 1.0, 33), np.zeros(33)).tolist()
    calm = made(lambda *_: Regime.SMOOTH)
    assert share_in(calm) == 1.0
    bounded = replace(calm, growth=rates)
    assert all(window.weight.high <= 160.0 - 320.0 * MARGIN for window in bounded.windows)
    assert "on the axis, does not grow in them" in " ".join(bounded.basis)
    twisting = replace(calm, growth=(-np.ones((33, 33))).tolist(), torsional=np.transpose(rates).tolist())
    assert all(window.speed.high <= 16.0 - 32.0 * MARGIN for window in twisting.windows)
    assert not bounded.calm[PLANE.steps, 0]


def test_few_runs_are_shown_as_few_and_carry_no_window():
    found = made(lambda *_: Regime.SMOOTH, every=16)  # cells of half the ranges are known by nothing
    assert not found.known.any()
    assert (found.windows, found.basis) == ([], [])
    scene = dt.load_scene("pa6_bench", {"wob": 40, "rpm": 90})
    assert "40 N at 1.5 rev/s: smooth in the nearest run; not known there" in "".join(shown_of(found, scene))
    assert made(lambda *_: Regime.SMOOTH, every=8).known.all()
    one = made(lambda *_: Regime.SMOOTH, every=8)
    some = replace(one, records={key: run for key, run in one.records.items() if key.i <= 8})
    assert all(window.weight.high <= 80.0 for window in some.windows)
    assert some.known.mean() == 0.25


EDGES = [(wob, rpm) for wob in (0.0, 5.0, 160.0, 315.0, 320.0) for rpm in (0.0, 0.5, 16.0, 31.5, 32.0)]


@pytest.mark.parametrize(("weight", "speed"), EDGES)
def test_a_set_point_on_an_edge_of_the_ranges_is_shown_too(weight, speed):
    scene = dt.load_scene("pa6_bench", {"wob": weight, "rig.rotation.value": speed})
    whole = made(lambda *_: Regime.SMOOTH)
    shown = "".join(shown_of(whole, scene))
    assert "set-point of the scene" in shown
    assert "not known there" not in shown
    low = replace(whole, records={key: run for key, run in whole.records.items() if key.i <= 16})
    assert ("not known there" in "".join(shown_of(low, scene))) == (weight > 160.0)  # what is known ends at 160 N
    assert low.is_known(weight, speed) == (weight <= 160.0)


def test_cells_are_those_that_a_place_touches():
    assert PLANE.cells_at((0.0, 32.0)) == (slice(0, 1), slice(31, 32))
    assert PLANE.cells_at((4.0, 4.5)) == (slice(3, 5), slice(4, 5))
    assert not np.ones((32, 32))[PLANE.cells_at((32.5, 1.0))].size
    assert not np.ones((32, 32))[PLANE.cells_at((-0.5, 1.0))].size


@pytest.mark.parametrize(
    "change", [{"wob": "1..17.3 N"}, {"rpm": "10..93.7"}, {"wob": "17.3..40 N", "rpm": "93.7..180"}]
)
def test_a_range_may_end_at_the_set_point_of_the_scene(change):
    asked = {"wob": "1..40 N", "rpm": "30..180", **change}
    over = {**COARSE, "wob": "17.3 N", "rpm": "93.7 rpm"}
    found = dt.operating_map("pa6_bench", over, duration=0.2, steps=8, runs=25, growth=False, **asked)
    assert "set-point of the scene, 17.3 N at 1.56" in "".join(shown_of(found, dt.load_scene("pa6_bench", over)))


@pytest.mark.parametrize("start", ["rotating", "axis"])
def test_a_map_says_what_rest_is_where_runs_begin_in_balance(start):
    """A well begins at speed: its map has no stick-slip that only a push brings."""
    over = COARSE | {"rig.start": start, "wob": "5 N"}
    found = dt.operating_map(
        "pa6_bench", over, wob="1..40 N", rpm="30..180", duration=0.2, steps=8, runs=4, growth=False
    )
    assert any("rig.start=axis begins at rest" in note for note in found.notes) == (start == "rotating")


@pytest.mark.parametrize("change", [{"wob": "40..40 N"}, {"rpm": "60..60"}])
def test_a_range_of_one_point_is_refused(change):
    with pytest.raises(ArgumentError, match="with LO below HI"):
        dt.operating_map("pa6_bench", COARSE, **{"wob": "1..40 N", "rpm": "30..180", **change})


@pytest.mark.parametrize("regime", [regime for regime in Regime if regime is not Regime.SMOOTH])
def test_no_other_regime_is_in_a_window(regime):
    found = made(lambda i, j: regime if (i, j) == (16, 16) else Regime.SMOOTH)
    assert not found.window_cells[15:17, 15:17].any()
    assert found.windows


def test_a_map_prints_one_line():
    found = made(lambda *_: Regime.SMOOTH)
    assert repr(found).startswith("OperatingMap(")
    assert "calm windows: 1" in repr(found)
    assert len(repr(found)) < 120


def test_a_run_that_failed_is_no_whirl():
    found = made(lambda i, _: Regime.FAILED if i > 16 else Regime.SMOOTH)
    assert not Regime.FAILED.whirls
    assert not found.whirls.any()
    assert not found.calm[20:].any()
    assert not made(lambda *_: Regime.FAILED).whirls.any()


def test_a_check_that_fails_takes_its_place_out_and_the_count_begins_anew():
    def checks(*regimes):
        places = [(FINER * (4 + k) + 7, FINER * 5 + 9) for k in range(len(regimes))]
        return {Key(i, j, 0, None, FINER): RunRecord(regime) for (i, j), regime in zip(places, regimes, strict=True)}

    good = replace(made(triangle, extra=checks(*[Regime.SMOOTH] * 9)), clean_checks=9)
    assert "9 more runs of 300 s" in " ".join(good.basis)
    assert f"{1.0 - (0.05 / 4) ** (1 / 9):.1%} of their set-points are not" in " ".join(good.basis)  # nothing of nine
    bad = made(triangle, extra=checks(Regime.SMOOTH, Regime.FORWARD, Regime.SMOOTH))
    assert not bad.window_cells[5, 5]
    assert "what share of their set-points is calm is not known" in " ".join(bad.basis)


class Checked:
    """Search whose checks fail by chance, whatever the rounds before found; the windows are the whole ranges."""

    def __init__(self, bad, seed):
        self.records, self.window_cells = {}, np.ones((4, 4), bool)
        self._bad, self._random = bad, np.random.default_rng(seed)

    def make(self, _phase, keys, **_):
        failed = self._random.random(len(keys)) < self._bad
        self.records |= {
            key: RunRecord(Regime.FORWARD if fails else Regime.SMOOTH) for key, fails in zip(keys, failed, strict=True)
        }


@pytest.mark.slow
@pytest.mark.parametrize("count", [5, 59])
def test_the_share_that_checks_show_is_false_in_one_of_twenty_maps_at_most(count):
    """Windows just worse than the claim, up to four looks, each of which may be the clean one (18 % as if one look)."""
    claim = none_of(count, ROUNDS)
    clean = [
        check(search, lambda search=search: search, 20 * count, 0)
        for search in (Checked(claim, k) for k in range(2000))
    ]
    assert set(clean) <= {0, count}
    assert 0.03 < np.mean(np.array(clean) > 0) < 0.05 + 2.0 * math.sqrt(0.05 * 0.95 / 2000)


def test_the_chance_of_whirl_holds_at_all_set_points_at_once():
    """Forty set-points, each just worse than the claim: one of them without whirl is chosen in one map of twenty."""
    draws, nodes, maps = 16, 40, 2000
    chance = none_of(draws, nodes)
    whirls = np.random.default_rng(0).random((maps, nodes, draws)) < chance
    assert (~whirls.any(axis=2)).any(axis=1).mean() < 0.05 + 2.0 * math.sqrt(0.05 * 0.95 / maps)
    alone = np.random.default_rng(0).random((maps, nodes, draws)) < none_of(draws)
    assert (~alone.any(axis=2)).any(axis=1).mean() > 0.8


def test_a_check_on_an_edge_between_cells_counts_in_both():
    """A check is drawn in a window with its edges; one on its upper edge was counted for the next cell alone."""
    good = made(lambda i, _: Regime.SMOOTH if i < 16 else Regime.FORWARD)
    _, k, j, _ = good.window_nodes[0]
    edge = Key(k * FINER, (j + 1) * FINER + 9, 0, None, FINER)
    assert replace(good, records={**good.records, edge: RunRecord(Regime.SMOOTH)}).window_cells[k - 1, j + 1]
    failed = replace(good, records={**good.records, edge: RunRecord(Regime.FORWARD)})
    assert not failed.window_cells[k - 1, j + 1]


def test_draws_are_counted_with_their_limit():
    """Three draws after the scene's own numbers, at all set-points of the map together."""
    extra = {Key(i, j, draw): RunRecord(triangle(i, j)) for i in range(33) for j in range(33) for draw in (1, 2, 3)}
    found = made(triangle, extra=extra, draws=({}, {}, {}, {}))
    said = f"the chance of whirl is below {1.0 - (0.05 / 33**2) ** (1 / 3):.1%} at all of these together"
    assert said in " ".join(found.basis)
    one = made(triangle, extra=extra | {Key(8, 8, 2): RunRecord(Regime.FORWARD)}, draws=({}, {}, {}, {}))
    assert one.whirls[8, 8]
    assert not one.window_cells[7:9, 7:9].any()


def test_draws_stop_where_one_whirls_and_are_all_made_where_none_does():
    asked = []

    class Drawn(Runner):
        def run(self, keys):
            asked.extend(keys)
            yield from ((key, RunRecord(Regime.FORWARD if key.draw == 2 and key.i < 8 else triangle(*key.node)))
                        for key in keys)  # fmt: skip

    runner = Drawn(dt.load_scene("pa6_bench", COARSE), PLANE, 30.0, 300.0, ({},) * 32, Threads())
    search = BoundarySearch(runner, None, 10**6, lambda *_: None, None)
    search.onset()
    search.draws()
    counts = {}
    for key in asked:
        counts.setdefault(key.node, []).append(key)
    for node, keys in counts.items():
        calm = triangle(*node) is Regime.SMOOTH
        assert len(keys) in ({1, 4, 32} if calm else {1})
        assert not (calm and len(keys) == 4) or node[0] < 8


def test_a_table_has_no_smooth_run_with_an_onset():
    from_whirl = RunRecord(Regime.SMOOTH, onset_s=9.0)
    found = made(
        triangle, extra={Key(3, 3, 0, (32, 32)): from_whirl, Key(32, 32): RunRecord(Regime.FORWARD, onset_s=5.0)}
    )
    rows = list(csv.DictReader(io.StringIO(found.csv())))
    assert not any(row["regime"] == "smooth" and row["onset_s"] for row in rows)
    assert any(row["onset_s"] == "5.0" for row in rows)


def test_the_smallest_cell_with_runs_decides():
    flags = np.zeros((33, 33), bool)
    flags[::8, ::8] = True
    calm = flags.copy()
    assert all(part.all() for part in known_and_calm(flags, calm))
    for node in ((0, 4), (4, 0), (4, 4), (4, 8), (8, 4)):
        flags[node] = True
        calm[node] = node != (4, 4)
    _, good = known_and_calm(flags, calm)
    assert not good[:8, :8].any()
    assert good[8:, 8:].all()


def test_rectangles_are_the_largest_and_then_those_that_add_most():
    safe = np.zeros((9, 9), bool)
    safe[0:2, :] = True
    safe[1:9, 1:4] = True
    assert rectangles(safe) == [(0, 9, 1, 4), (0, 2, 0, 9)]
    assert rectangles(np.zeros((9, 9), bool)) == []


def test_a_trend_is_told_to_the_end_of_the_time_asked():
    grows = Trend(np.array([1e-5, 2e-3]), np.array([1e-5, 4e-3]), 7.5)
    assert grows.rate == pytest.approx(math.log(2.0) / 7.5)
    assert grows.reaches(0.05, 30.0)  # 4e-3 times 2 to the 4
    assert not grows.reaches(0.05, 25.0)
    steady = Trend(np.array([0.2]), np.array([0.21]), 7.5)
    assert not steady.reaches(0.05, 300.0)
    noise = Trend(np.array([1e-12]), np.array([4e-9]), 7.5)
    assert not noise.reaches(0.05, 300.0)


def test_a_bit_that_sticks_or_stands_is_not_calm():
    assert TorsionalSpeeds(1.05, 12.0, 12.0).sticks
    assert TorsionalSpeeds(0.0, 0.0, 12.0).sticks
    assert not TorsionalSpeeds(0.2, 12.0, 12.0).sticks
    assert TorsionalSpeeds(0.2, 11.0, 12.0).winds
    assert not TorsionalSpeeds(0.0, 0.0, 0.0).sticks


def test_a_run_whose_whirl_would_begin_after_it_is_not_settled():
    """1.2 N at 2.6 rev/s: whirl after minutes, so a run of 30 s is not smooth; it grows as the linear string does."""
    from drill_twin.dynamics.rotordynamics.campbell import growth_map
    from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion

    scene = dt.load_scene("pa6_bench", COARSE)
    plane = Plane(Span(1.2, 2.0), Span(math.tau, 2.6 * math.tau), 8)
    runner = Runner(scene, plane, 30.0, 300.0, (), Threads(2))
    records = dict(runner.run([Key(8, 0), Key(0, 8)]))
    assert records[Key(8, 0)].regime is Regime.SMOOTH
    assert records[Key(0, 8)].regime is Regime.UNSETTLED
    linear = growth_map(EquationsOfMotion(scene), np.array([1.2]), np.array([2.6 * math.tau])).lateral[0, 0]
    assert linear > 0.0
    assert records[Key(0, 8)].growth == pytest.approx(linear, rel=0.2)
