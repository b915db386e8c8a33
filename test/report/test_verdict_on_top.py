# SPDX-License-Identifier: Apache-2.0
"""The verdict on top says what the string does, how severe it is, and nothing that the summary does not hold."""

import pytest
from summaries import summarise

from drill_twin.report.verdict import first_rows, verdict
from drill_twin.whirl import MotionState

WHIRLS = {
    "onset_s": 5.37, "onset_at_start": False, "whirl_end_s": None, "lasting_motion": "forward whirl",
    "whirl_frequency_hz": 1.081, "whirl_frequency_changes": False, "whirl_observable": True, "version": "0.1.0",
}  # fmt: skip


@pytest.fixture(scope="module")
def summary(known_bag):
    return summarise(known_bag)


def said(summary, **changes):
    return verdict({**summary, **WHIRLS, **changes}, "out/x/bag_0")


def test_verdict_of_a_run_is_of_its_summary(bench_run):
    found = summarise(bench_run.bag)
    whirl, severity, *command = verdict(found, "here")
    assert found["onset_at_start"]
    assert whirl.startswith("Whirl from the start of what was analysed: the string ")
    assert whirl.endswith("mark_2, mark_3, mark_4 reached the wall.")
    assert severity.startswith(f"Severity {found['severity']['word']}: ")
    assert command == ["The cause is not computed yet: drill-twin analyze here --why"]
    names = [name.partition(",")[0] for name, _ in first_rows(found)]
    index = ["stick-slip index"] * (found["stick_slip_index"] is not None)
    assert names == ["onset of whirl", "whirl frequency", "largest radius", "bounds of severity", *index, "set-points"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "Whirl from 5.37 s: the string whirls forward at 1.08 Hz"),
        ({"whirl_frequency_changes": True}, "whirls forward at 1.08 Hz, still changing"),
        ({"lasting_motion": "rolling along the wall", "whirl_frequency_hz": -3.0},
         "rolls backward along the wall at 3.00 Hz"),
        ({"lasting_motion": "spiral", "whirl_frequency_hz": -3.0}, "in the shape of a helix, backward at 3.00 Hz"),
        ({"onset_at_start": True}, "Whirl from the start of what was analysed: "),
        ({"whirl_end_s": 9.0, "lasting_motion": "rotation about a fixed axis"},
         "Whirl from 5.37 s to 9.00 s, and none since: the string turns about a fixed axis"),
        ({"lasting_motion": "irregular"}, "whirls irregularly (chaotic whirl)"),
        ({"onset_s": None, "lasting_motion": "swinging in a plane", "duration_s": 60.0},
         "No whirl was found in 60 s: the string swings in a plane, which is no whirl."),
    ],
)  # fmt: skip
def test_each_motion_has_its_sentence(summary, changes, words):
    assert words in said(summary, **changes)[0]


def test_a_bag_of_several_runs_says_which_one_it_is(summary):
    assert said(summary, runs=3, run=2)[0].startswith("Run 2 of 3. Whirl from 5.37 s: ")


def test_a_run_that_cannot_show_whirl_is_not_said_to_have_none(summary):
    quality = {**summary["quality"], "samples_per_revolution": 3.14}
    assert said(summary, onset_s=None, quality=quality)[0].startswith("Whirl: not observable: 3.1 samples")


def test_a_string_without_whirl_that_is_bent_to_the_wall_is_said_to_be(summary):
    radii, room = {"a": 0.089, "b": 0.02}, {"a": 0.1, "b": 0.1}
    calm = {"onset_s": None, "lasting_motion": "rotation about a fixed axis", "clearance_m": room}
    assert said(summary, **calm, max_radius_m=radii)[0].endswith("axis; a was up to 89% of the clearance off the axis.")
    assert said(summary, **calm, max_radius_m={"a": 0.099})[0].endswith("axis; a touched the wall.")
    assert said(summary, **calm, max_radius_m={"a": 0.01})[0].endswith(": the string turns about a fixed axis.")
    assert said(summary, **calm, truncated=True)[0].startswith("The bag is not whole. No whirl was found")
    assert said(summary, **calm, duration_s=0.05)[0].startswith("Whirl: not known, as the string turned ")


@pytest.mark.parametrize("state", MotionState)
def test_every_state_of_motion_has_words(summary, state):
    whirl = said(summary, lasting_motion=state.value)[0]
    assert ("not observable" in whirl) == (state is MotionState.NOT_OBSERVABLE)


def test_only_marks_that_touched_are_said_to_have_reached_the_wall(summary):
    room = dict.fromkeys(("a", "b", "c", "d"), 0.1)
    radii = {"a": 0.1, "b": 0.097, "c": 0.09, "d": None}
    assert said(summary, max_radius_m=radii, clearance_m=room)[0].endswith("; a, b reached the wall.")
    assert said(summary, max_radius_m=radii, clearance_m={})[0].endswith("1.08 Hz.")
    radii = dict.fromkeys(room, 0.1)
    assert said(summary, max_radius_m=radii, clearance_m=room)[0].endswith("; 4 of 4 marks reached the wall.")


def test_a_cause_is_offered_only_where_it_can_be_computed_and_is_not_known(summary):
    def offered(**changes):
        return any("--why" in sentence for sentence in said(summary, **changes))

    assert offered(scene="pa6_bench")
    assert not offered(scene=None)
    assert not offered(scene="pa6_bench", version="")
    assert not offered(scene="pa6_bench", cause={})
    assert not offered(scene="pa6_bench", onset_s=None, severity=None)
