# SPDX-License-Identifier: Apache-2.0
"""Topics of a bag as arrays are the numbers that went in."""

import numpy as np
import pytest

from drill_twin.errors import BagError
from drill_twin.io.bag import series
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.topics import MARKS_STATE, RIG_COMMAND, RIG_STATE, STRING_POSES, WHIRL_STATE

MARKS = ("mark_1", "mark_2", "mark_3", "mark_4")


@pytest.fixture
def bag(write_bag):
    return Bag(write_bag())


def test_poses(bag, frames):
    poses = series.pose_series(bag)
    np.testing.assert_allclose(poses.time, [frame.time for frame in frames], rtol=1e-15)
    np.testing.assert_array_equal(poses.position, [frame.positions for frame in frames])
    assert poses.orientation.shape == (40, 11, 4)


def test_spin_is_unwrapped(write_bag, make_frame, make_geometry):
    """Three quarters of a turn from one sample to the next."""
    import dataclasses

    from drill_twin.io.messages.encode import TwinEncoder

    encoder, rows = TwinEncoder(make_geometry(11)), []
    for k in range(200):
        frame = dataclasses.replace(make_frame(11, time=0.01 * k), spin=np.full(11, 1.5 * np.pi * k))
        rows.append((STRING_POSES, k, encoder.poses(frame)))
    spin = series.pose_series(Bag(write_bag(rows=rows))).spin
    np.testing.assert_allclose(spin[-1] - spin[0], 1.5 * np.pi * 199)


def test_marks(bag, frames):
    marks = series.mark_series(bag)
    assert marks.names == MARKS
    for name in ("position", "velocity", "spin", "spin_rate"):
        np.testing.assert_array_equal(getattr(marks, name), [getattr(frame.marks, name) for frame in frames])
    np.testing.assert_allclose(marks.wall_force, [frame.marks.wall_force for frame in frames], rtol=1e-14)


def test_rig(bag, frames):
    rig = series.rig_series(bag)
    for name in frames[0].rig.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(rig, name), [getattr(frame.rig, name) for frame in frames])


def test_commands(bag):
    commands = series.command_series(bag)
    np.testing.assert_array_equal(commands.weight_on_bit, np.full(40, 40.0))
    np.testing.assert_array_equal(commands.rotation, np.full(40, 4.0 * np.pi))


def test_whirl(bag, frames):
    whirl = series.whirl_series(bag)
    assert whirl.names == MARKS
    for values in (whirl.orbit_radius, whirl.precession, whirl.ratio, whirl.confidence):
        np.testing.assert_array_equal(values, np.tile([[frame.time] for frame in frames], 4))


def test_findings_in_words(bag, onset, motion):
    assert series.onset(bag) == onset
    assert series.motions(bag) == [(390_000_000, [motion])]
    assert series.diagnostics(bag)[0][1][0].name == "simulator"


def test_no_findings(write_bag, messages):
    bag = Bag(write_bag(rows=messages[:3]))
    assert series.onset(bag) is None
    assert series.motions(bag) == series.diagnostics(bag) == []


def test_what_is_missing_is_named(write_bag, messages):
    bag = Bag(write_bag(rows=messages[:3]))
    with pytest.raises(BagError, match=r"expected messages on /string/poses, found none; the bag holds .*/rig/command"):
        series.pose_series(bag)


def test_two_scenes_in_a_bag(write_bag):
    rows = [(STRING_POSES, n, PoseArrayTemplate(n).fill(n, np.zeros((n, 3)), np.zeros((n, 4)))) for n in (3, 4)]
    with pytest.raises(BagError, match="more than one scene"):
        series.pose_series(Bag(write_bag(rows=rows)))
    rows = [(RIG_STATE, 0, JointStateTemplate([name]).fill(0, [0.0], [0.0], [0.0])) for name in ("a", "b")]
    with pytest.raises(BagError, match="expected the joints a on /rig/state throughout, found b at"):
        series.joint_series(Bag(write_bag("b_0", rows=rows)), RIG_STATE)


@pytest.mark.parametrize("topic", [STRING_POSES, MARKS_STATE, RIG_STATE, RIG_COMMAND, WHIRL_STATE])
def test_bytes_that_are_no_message(write_bag, topic):
    bag = Bag(write_bag(rows=[(topic, 7, b"\0\1\0\0rubbish")]))
    read = {
        STRING_POSES: series.pose_series,
        MARKS_STATE: series.mark_series,
        RIG_STATE: series.rig_series,
        RIG_COMMAND: series.command_series,
        WHIRL_STATE: series.whirl_series,
    }[topic]
    with pytest.raises(BagError, match=f"{topic} recorded at 7 ns: expected the CDR bytes of a") as caught:
        read(bag)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("topic", "read"),
    [
        (MARKS_STATE, series.mark_series),
        (RIG_STATE, series.rig_series),
        (RIG_COMMAND, series.command_series),
        (WHIRL_STATE, series.whirl_series),
    ],
)
@pytest.mark.parametrize("names", [["a"], ["mark_1/x"], ["mark_1/orbit_radius"], ["bit"]])
def test_other_joints_are_refused(write_bag, topic, read, names):
    ones = np.ones(len(names))
    raw = JointStateTemplate(names).fill(0, ones, ones, ones)
    with pytest.raises(BagError, match="expected"):
        read(Bag(write_bag(rows=[(topic, 0, raw)])))


def test_a_scene_without_marks(write_bag):
    nothing = JointStateTemplate([]).fill(0, (), (), ())
    bag = Bag(write_bag(rows=[(MARKS_STATE, 0, nothing), (WHIRL_STATE, 0, nothing)]))
    assert series.mark_series(bag).position.shape == (1, 0, 3)
    assert series.whirl_series(bag).ratio.shape == (1, 0)


def test_empty_arrays_are_refused(write_bag):
    names = [f"mark_1/{axis}" for axis in ("x", "y", "z", "spin")]
    raw = JointStateTemplate(names, effort=False).fill(0, np.ones(4), np.ones(4))
    with pytest.raises(BagError, match="found one of them empty"):
        series.mark_series(Bag(write_bag(rows=[(MARKS_STATE, 0, raw)])))
