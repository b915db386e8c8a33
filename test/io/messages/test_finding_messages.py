# SPDX-License-Identifier: Apache-2.0
"""Findings of the analyzer are decoded bit for bit, so that live and offline analysis can be compared."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
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
finite = st.floats(allow_nan=False)


def test_whirl_state():
    values = np.random.default_rng(1).normal(size=(4, 3))
    values[0, 1] = np.nan
    raw = WhirlStateEncoder(["mark_1", "mark_2", "bit/centre"]).encode(17, *values)
    joints = read_joint_state(raw)
    assert joints.names[:4] == tuple(f"mark_1/{s}" for s in ("orbit_radius", "precession", "ratio", "confidence"))
    assert joints.velocity.size == joints.effort.size == 0
    state = read_whirl_state(joints)
    assert (state.stamp, state.marks) == (17, ("mark_1", "mark_2", "bit/centre"))
    np.testing.assert_array_equal((state.orbit_radius, state.precession, state.ratio, state.confidence), values)


def test_other_joints_are_not_findings():
    raw = JointStateTemplate(["mark_1/orbit_radius", "mark_1/x"]).fill(0, np.ones(2), np.ones(2), np.ones(2))
    with pytest.raises(MessageError, match="expected the joints"):
        read_whirl_state(read_joint_state(raw))


@settings(max_examples=50, deadline=None)
@given(st.lists(st.builds(SubjectMotion, words, words, words), max_size=5), st.integers(0, 2**60))
def test_motion(motions, stamp):
    assert decode_motion(encode_motion(stamp, motions)) == (stamp, motions)


@settings(max_examples=100, deadline=None)
@given(st.builds(OnsetMessage, finite, words, finite, st.none() | finite, st.booleans()), st.integers(0, 2**60))
def test_onset(onset, stamp):
    found_stamp, found = decode_onset(encode_onset(stamp, onset))
    assert (found_stamp, found) == (stamp, onset)
    assert np.float64(found.time).tobytes() == np.float64(onset.time).tobytes()


def test_numpy_scalars_are_written_as_numbers():
    onset = OnsetMessage(np.float64(6.12), "mark_3", np.float64(0.9))
    assert decode_onset(encode_onset(1, onset)) == (1, OnsetMessage(6.12, "mark_3", 0.9))


def test_no_onset_so_far():
    assert decode_onset(encode_onset(3, None)) == (3, None)


@pytest.mark.parametrize(
    ("status", "found"),
    [
        (Status("something else", Level.OK, ""), "expected a status 'whirl onset'"),
        (Status("whirl onset", Level.WARN, "", {"time": "soon", "mark": "m", "confidence": "1"}), "expected time"),
        (Status("whirl onset", Level.WARN, "", {"time": "1.0"}), "expected time, mark and confidence"),
    ],
)
def test_an_onset_that_is_none_is_refused(status, found):
    with pytest.raises(MessageError, match=found):
        decode_onset(encode_diagnostics(0, [status]))


def test_other_diagnostics_are_no_motion():
    with pytest.raises(MessageError, match="motion: <mark>"):
        decode_motion(encode_diagnostics(0, [Status("simulator", Level.OK, "fine")]))
