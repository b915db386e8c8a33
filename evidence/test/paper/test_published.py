# SPDX-License-Identifier: Apache-2.0
"""The published numbers are the paper's, and each is compared with the right number of ours."""

import math

import pytest

from drill_twin.core.errors import SceneError
from drill_twin.scene import load_scene
from drill_twin_evidence.paper.runs.cases import LOADS, MATRIX, SPEEDS, Case, changed, scene_of, value_at
from drill_twin_evidence.paper.runs.full_size import CASES as FULL_SIZE
from drill_twin_evidence.paper.runs.published import Published, published
from drill_twin_evidence.paper.runs.run import Measured
from drill_twin_evidence.paper.runs.similarity import similarity
from drill_twin_evidence.paper.runs.table import rows, surge_speed, trends

# The paper's text: sections 3.2.1 and 3.2.2.2, conclusions 2 and 3.
BENCH = {
    "critical time, 20 N, 2 rev/s": 7.24, "critical time, 40 N, 2 rev/s": 6.12, "critical time, 300 N, 2 rev/s": 0.89,
    "whirl frequency, 20 N, 2 rev/s": 1.12, "whirl frequency, 150 N, 2 rev/s": 0.28,
    "whirl frequency, 300 N, 2 rev/s": 0.29,
    "largest displacement mark_3, 40 N, 2 rev/s": 75.0, "largest displacement mark_2, 40 N, 2 rev/s": 50.0,
    "largest displacement mark_1, 40 N, 2 rev/s": 20.0,
    **{f"whirl ratio, 40 N, {speed} rev/s": 0.5 for speed in (1, 2, 3, 4)},
    **{f"whirl ratio, 40 N, {speed} rev/s": 1.0 for speed in (6, 6.5)},
}  # fmt: skip


def test_the_published_numbers_of_the_bench_are_those_of_the_text():
    assert {number.name: number.value for number in published().bench} == BENCH
    assert (published().surge.low, published().surge.high, published().similarity) == (4.0, 5.0, 21.6)


def test_the_published_numbers_of_the_full_size_assembly_are_those_of_the_text():
    ranges = {row.what: (row.low, row.high) for row in published().full_size}
    assert ranges == {
        "near-bit velocity before whirl": (-0.5, 0.53), "near-bit velocity in whirl": (-1.104, 1.097),
        "far-bit velocity before whirl": (-0.363, 0.506), "far-bit velocity in whirl": (-1.429, 1.258),
        "steady rotation from": (1.44, 1.44), "lateral vibration from": (3.51, 3.51),
        **{f"near-bit displacement at {load} kN": (-150.0, 150.0) for load in (100, 150, 200)},
    }  # fmt: skip


def test_the_runs_are_those_of_table_2():
    assert LOADS == (20, 40, 60, 80, 100, 150, 200, 250, 300)
    assert SPEEDS == (1, 2, 3, 4, 5, 6, 6.5)
    assert len(set(MATRIX)) == len(MATRIX) == 15  # 40 N at 2 rev/s belongs to both sweeps
    assert {Case(n.weight_on_bit, n.speed) for n in published().bench} <= set(MATRIX)
    assert [round(case.speed * 60) for case in FULL_SIZE] == [50, 50, 50, 50, 40, 60, 80, 100]


def test_a_broken_table_of_published_numbers_is_one_clear_error(monkeypatch: pytest.MonkeyPatch, tmp_path):
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "published.yaml").write_text("bench: [{q: Q1}]\n")
    monkeypatch.setattr("drill_twin_evidence.paper.runs.published.CONFIG", tmp_path)
    published.cache_clear()
    try:
        with pytest.raises(SceneError, match=r"published.yaml: expected the published numbers"):
            published()
    finally:
        published.cache_clear()


def measured(onset: float, frequency: float, speed: float = 2.0, **marks: float) -> Measured:
    size = {"mark_1": 20.0, "mark_2": 50.0, "mark_3": 75.0, **marks}
    return Measured(onset, frequency, frequency / speed, abs(frequency), size, ())


def perfect() -> dict[Case, Measured]:
    """What the paper would measure on itself, with its trends filled in between."""
    loads = {20: (7.24, 1.12), 40: (6.12, 1.0), 60: (4.5, 0.8), 80: (3.2, 0.6), 100: (2.2, 0.4), 150: (1.2, 0.28),
             200: (1.1, 0.27), 250: (1.0, 0.265), 300: (0.89, 0.26)}  # fmt: skip
    found = {Case(float(load), 2.0): measured(*values) for load, values in loads.items()}
    for speed in SPEEDS:
        ratio = 0.5 if speed <= 4.0 else 1.0
        found[Case(40.0, speed)] = measured(8.12 - speed, ratio * speed, speed)
    return found


def test_a_perfect_twin_would_have_every_number_and_every_trend():
    results = perfect()
    assert all(row.near for row in rows(results))
    assert [trend.published for trend in trends(results) if not trend.right] == []
    assert surge_speed(results) == 4.5
    assert isinstance(published(), Published)


@pytest.mark.parametrize(
    ("case", "worse", "trend"),
    [
        (Case(40.0, 6.5), measured(9.0, 6.5, 6.5), "critical time falls with speed"),
        (Case(100.0, 2.0), measured(4.0, 0.4), "critical time falls with weight on bit"),
        (Case(150.0, 2.0), measured(2.1, 0.28), "critical time: steep at first, then flat"),
        (Case(40.0, 3.0), measured(5.12, 0.9, 3.0), "whirl frequency rises with speed"),
        (Case(100.0, 2.0), measured(2.2, 0.7), "whirl frequency falls with weight on bit to 150 N"),
        (Case(300.0, 2.0), measured(0.89, 0.9), "whirl frequency: flat from 150 N"),
        (Case(40.0, 2.0), measured(6.12, 1.0, mark_2=80.0), "displacement grows towards the bit"),
        (Case(40.0, 4.0), measured(4.12, 4.0, 4.0), "whirl over rotation surges at 4-5 rev/s"),
        (Case(40.0, 1.0), measured(math.inf, 0.5, 1.0), "critical time nearly linear in speed"),
    ],
)
def test_each_trend_can_be_wrong(case, worse, trend):
    found = {t.published: t.right for t in trends({**perfect(), case: worse})}
    assert found[trend] is False


def test_backward_whirl_counts_as_a_frequency_but_not_as_a_forward_ratio():
    results = {Case(20.0, 2.0): measured(7.0, -1.12), Case(40.0, 2.0): measured(6.0, -1.0)}
    found = {row.number.name: row for row in rows(results)}
    assert found["whirl frequency, 20 N, 2 rev/s"].near
    assert not found["whirl ratio, 40 N, 2 rev/s"].near
    assert found["whirl ratio, 40 N, 6 rev/s"].ours is None


def test_the_scene_of_a_case_changes_what_it_says_and_nothing_else():
    scene = load_scene("pa6_bench")
    other = scene_of(scene, Case(150.0, 3.0), {"effects.drag.linear": 0.5})
    assert value_at(other, "rig.weight_on_bit.value") == 150.0
    assert value_at(other, "rig.rotation.value") == pytest.approx(6.0 * math.pi)
    assert value_at(other, "effects.drag.linear") == 0.5
    back = scene_of(other, Case(40.0, 2.0), {"effects.drag.linear": scene.effects.drag.linear})
    assert back == scene
    with pytest.raises(AttributeError):
        changed(scene, "effects.no_such.value", 1.0)


def test_similarity_gives_the_papers_factor_and_the_loads_of_both_scales():
    said = " ".join(f"{s.what} {s.rod} {s.field} {s.why}" for s in similarity(load_scene("pa6_bench")))
    for words in ("21.63 r/min", "127.3 mm", "38.5 m", "693 mm", "1 N is 2.5", "1 N is 0.95 kN"):
        assert words in said
