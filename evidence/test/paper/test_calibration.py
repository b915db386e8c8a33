# SPDX-License-Identifier: Apache-2.0
"""The search finds what it is asked for, from where it starts."""

import pytest

from drill_twin.scene import load_scene
from drill_twin_evidence.paper.calibration import calibrate as module
from drill_twin_evidence.paper.calibration.calibrate import calibrate
from drill_twin_evidence.paper.calibration.objective import FITTED, LARGEST, Loss, evaluate, lateral, loss
from drill_twin_evidence.paper.calibration.parameters import PARAMETERS, shares_of, with_shares
from drill_twin_evidence.paper.calibration.trade_off import draw_trade_off, front, groups, point

WANTED = (0.3, 0.7, 0.5, 0.4, 0.6, 0.2, 0.8, 0.45, 0.55, 0.35)


def bowl(scenes, _workers, done):
    """Losses whose least value is known."""
    wanted = [sum(20.0 * (x - w) ** 2 for x, w in zip(shares_of(scene), WANTED, strict=True)) for scene in scenes]
    losses = [Loss(total, {}) for total in wanted]
    for one in losses:
        done(one)
    return losses


@pytest.fixture
def quick_search(monkeypatch, quick_bench):
    monkeypatch.setattr(module, "evaluate", bowl)

    def search(**more):
        given = {"seed": 3, "population": 16, "generations": 60, "processes": 1, "progress": lambda *_told: None}
        return calibrate(quick_bench, **{**given, **more})

    return search


def test_the_search_finds_the_bottom(quick_search):
    done = quick_search()
    assert done.best.total < 0.02
    assert done.shares == pytest.approx(WANTED, abs=0.05)
    assert done.changes["effects.bow.amplitude"] == pytest.approx(PARAMETERS[2].value(done.shares[2]))
    assert quick_search() == done  # the seed decides
    assert quick_search(seed=4).shares != done.shares


def test_no_generations_give_the_scene_as_it_is(quick_search, quick_bench):
    done = quick_search(generations=0)
    assert done.shares == tuple(shares_of(quick_bench))
    assert done.tried == (done.best,)


def test_numbers_and_shares_are_each_others_and_lie_within_the_bounds():
    scene = load_scene("pa6_calibrated")
    shares = shares_of(scene)
    assert all(0.0 < share < 1.0 for share in shares), "a number of the scene lies outside its bounds"
    again = with_shares(scene, shares)
    assert shares_of(again) == pytest.approx(shares)
    damping = again.effects.internal_damping
    assert damping.bending_time == damping.stretch_time == damping.torsion_time
    low, high = with_shares(scene, [0.0] * len(PARAMETERS)), with_shares(scene, [1.0] * len(PARAMETERS))
    assert low.effects.bow.amplitude == pytest.approx(1e-5)
    assert high.effects.drag.linear == pytest.approx(0.1)


def test_a_run_without_findings_costs_most_but_not_everything(quick_bench):
    found, again = evaluate([quick_bench, quick_bench], 2)
    assert found == again
    assert all(0.0 <= e <= LARGEST for e in found.deviations.values())
    nothing = loss({})
    assert set(nothing.deviations.values()) == {LARGEST}
    assert found.total < nothing.total
    assert lateral(load_scene("pa6_calibrated")).effects.stretch is None


def test_what_excludes_what_is_what_nothing_beats():
    assert front([(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (2.5, 2.5), (1.0, 4.0), (3.0, 3.0)]) == [
        (1.0, 3.0),
        (2.0, 2.0),
        (3.0, 1.0),
    ]
    fast, slow = groups()
    assert {number.q for number in fast} == {"Q11", "Q12", "Q15"}
    assert {number.q for number in slow} == {"Q16", "Q17"}
    deviations = {number.name: 3.0 if number in slow else 0.5 for number in FITTED}
    loss = Loss(1.0, deviations)
    assert point(loss) == pytest.approx((0.5, 3.0))
    labels = draw_trade_off([loss, Loss(1.0, dict.fromkeys(deviations, 1.0))], loss).axes[0]
    assert labels.get_xticklabels()[-1].get_text() == labels.get_yticklabels()[-1].get_text() == "≥ 8"
    assert all(number.name in labels.get_xlabel() for number in fast)
    assert all(number.name in labels.get_ylabel() for number in slow)
