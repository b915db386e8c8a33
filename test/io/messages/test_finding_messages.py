# SPDX-License-Identifier: Apache-2.0
"""Findings of the analyzer are decoded bit for bit, so that live and offline analysis can be compared."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics
from drill_twin.io.messages.whirl_encode import (
    OnsetMessage,
    SubjectMotion,
    WhirlStateEncoder,
    decode_motion,
    decode_onset,
    encode_motion,
    encode_onset,
    read_whirl_state,
)

words = st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\0"), max_size=20)


def test_whirl_state():
    values = np.random.default_rng(1).normal(size=(5, 3))
    values[0, 1] = np.nan
    (raw,) = WhirlStateEncoder(["mark_1", "mark_2", "bit/centre"]).rows([17], values.T[None])
    joints = read_joint_state(raw)
    scalars = ("orbit_radius", "precession", "ratio", "confidence", "motion")
    assert joints.names[:5] == tuple(f"mark_1/{scalar}" for scalar in scalars)
    assert joints.velocity.size == joints.effort.size == 0
    marks, found = read_whirl_state(joints)
    assert (joints.stamp, marks) == (17, ("mark_1", "mark_2", "bit/centre"))
    np.testing.assert_array_equal(found, values.T)


def test_other_joints_are_not_findings():
    raw = JointStateTemplate(["mark_1/orbit_radius", "mark_1/x"]).fill(0, np.ones(2), np.ones(2), np.ones(2))
    with pytest.raises(MessageError, match="expected the joints"):
        read_whirl_state(read_joint_state(raw))


@settings(max_examples=50, deadline=None)
@given(st.lists(st.builds(SubjectMotion, words, words, words), max_size=5), st.integers(0, 2**60))
def test_motion(motions, stamp):
    assert decode_motion(encode_motion(stamp, motions)) == (stamp, motions)


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 2**60), words, st.integers(0, 2**60))
def test_onset_to_the_nanosecond(time, mark, stamp):
    onset = OnsetMessage(time / 1e9, mark)
    found_stamp, found = decode_onset(encode_onset(stamp, onset))
    assert found_stamp == stamp
    assert found == (pytest.approx(onset.time, rel=1e-15, abs=1e-9), mark)


def test_an_onset_at_time_zero_is_none_of_none():
    onset = decode_onset(encode_onset(3, OnsetMessage(0.0, "mark_3")))[1]
    assert onset == (1e-9, "mark_3")
    assert decode_onset(encode_onset(3, None)) == (3, None)


def test_the_sentence_on_the_onset_is_in_the_motion_of_the_string():
    motions = [SubjectMotion("string", "irregular", ""), SubjectMotion("mark_1", "irregular", "")]
    _, (string, mark) = decode_diagnostics(encode_motion(0, motions, onset="whirl began at 5.19 s"))
    assert string.values["onset"] == "whirl began at 5.19 s"
    assert "onset" not in mark.values


def test_diagnostics_are_no_onset():
    with pytest.raises(MessageError, match="TimeReference"):
        decode_onset(encode_diagnostics(0, [Status("whirl onset", Level.WARN, "")]))


def test_other_diagnostics_are_no_motion():
    with pytest.raises(MessageError, match="motion: <mark>"):
        decode_motion(encode_diagnostics(0, [Status("simulator", Level.OK, "fine")]))
