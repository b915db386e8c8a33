# SPDX-License-Identifier: Apache-2.0
"""A verdict names the worse assembly, and none of two that are the same."""

import pytest

from drill_twin.api.compare import finish, prepare
from drill_twin.api.verdict import CHANCE, NONE, ComparedCost, _better, again, costs, verdicts
from drill_twin.core.units.system import SYSTEMS


@pytest.fixture(scope="module")
def first():
    return prepare(
        "pa6_bench", {"duration": "6 s", "rig.weight_on_bit.duration": "4 s", "rig.rotation.duration": "4 s"}
    )


def verdict(first, other):
    scenes = [
        first,
        prepare(other, {"duration": "6 s", "rig.weight_on_bit.duration": "4 s", "rig.rotation.duration": "4 s"}),
    ]
    cases = [finish(str(k), scene) for k, scene in enumerate(scenes)]
    found = costs([cases, *(again(cases, scenes, seed) for seed in (1, 2))], 0.05)
    return verdicts(found, SYSTEMS["lab"])[0]


@pytest.mark.long
def test_the_same_assembly_in_other_seeds_is_no_better(first):
    assert verdict(first, "pa6_bench,numerics.seed=70").startswith(f"A and B: {NONE}")


@pytest.mark.slow
def test_the_worse_assembly_is_named_with_figures(first):
    said = verdict(first, "pa6_bench,wob=80 N")
    assert said.startswith("A is better than B, decided by lateral acceleration, rms ")
    assert "(low) against" in said
    assert "; also: bending stress" in said
    assert "MPa" in said


@pytest.mark.parametrize(
    ("one", "other", "sign", "better"),
    [
        ((1.0, 1.1, 0.9), (2.0, 2.1, 1.9), 1.0, "A"), ((1.0, 1.1, 0.9), (2.0, 2.1, 1.9), -1.0, "B"),
        ((1.0, 1.8, 0.4), (1.5, 2.2, 0.6), 1.0, CHANCE),  # within the spread
        ((1.0, 1.01), (2.0, 2.01), 1.0, "A"), ((1.0, 1.3), (2.0, 2.3), 1.0, CHANCE),  # two runs tell little
        ((1.0, 1.0, 1.0), (1.01, 1.01, 1.01), 1.0, ""),  # within the tolerance
        ((1.0,), (9.0,), 1.0, ""),  # one run has no spread
    ],
)  # fmt: skip
def test_a_difference_is_beyond_tolerance_and_chance(one, other, sign, better):
    assert _better(one, other, sign, (0.05, 0.0), "B", 8) == better
    assert _better(one, other, sign, (0.05, 10.0), "B", 8) == ""  # less than matters


def test_both_sides_are_told():
    row = ((1.0, 1.0), (2.0, 2.0))
    found = [
        ComparedCost("stick-slip index", "-", row, ("A",)),
        ComparedCost("rate of penetration", "m/s", row, ("B",)),
    ]
    said = verdicts(found, SYSTEMS["si"])[0]
    assert said.startswith("A is better than B, decided by stick-slip index 1 against 2; against it: rate of ")
    unsure = [ComparedCost("stick-slip index", "-", row, (CHANCE,))]
    assert verdicts(unsure, SYSTEMS["si"])[0].endswith(
        f"{NONE}; stick-slip index 1 against 2: the means differ, which 2 runs do not tell from chance (more --repeats)"
    )
    single = [ComparedCost("stick-slip index", "-", ((1.0,), (2.0,)), ("",))]
    assert verdicts(single, SYSTEMS["si"])[0].startswith("no verdict")


def test_the_highest_grade_decides_or_nothing_does():
    ungraded = ComparedCost("specific energy", "-", ((2.0, 2.0), (1.0, 1.0)), ("B",))
    graded = ComparedCost("stick-slip index", "-", ((0.04, 0.05), (0.1, 0.6)), (CHANCE,), 0.06, (0, 1))
    said = verdicts([ungraded, graded], SYSTEMS["si"])[0]
    assert said.startswith("A and B: not decided, as the highest grade may be one by chance; stick-slip index 0.045 ")
    assert said.endswith("(more --repeats); B is better by specific energy 1 against 2")
    calm = graded._replace(grades=(0, 0))  # a difference without a grade hides no other
    assert verdicts([ungraded, calm], SYSTEMS["si"])[0].startswith("B is better than A, decided by specific ")
