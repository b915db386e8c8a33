# SPDX-License-Identifier: Apache-2.0
"""A result as a table of pandas, and as a moving picture."""

import shutil

import numpy as np
import pytest
from PIL import Image

import drill_twin as dt
from drill_twin.core.errors import ArgumentError


@pytest.fixture(scope="module")
def result():
    return dt.Simulation("pa6_bench").run(duration=1.0)


def test_a_table_has_the_arrays_with_their_units(result):
    pytest.importorskip("pandas")
    table = result.to_pandas()
    assert table.index.name == "time [s]"
    assert np.array_equal(table["hookload [N]"], result.hookload)
    mark = result.marks.names.index("mark_2")
    assert np.array_equal(table["mark_2/position/y [m]"], result.marks.position[:, mark, 1])
    assert np.array_equal(table["mark_2/spin [rad]"], result.marks.spin[:, mark])


def test_a_moving_picture_has_frames_that_differ(result, tmp_path):
    with Image.open(result.animate(tmp_path / "new" / "run.gif", begin=0.5, end=1.0, speed=2.0)) as moving:
        assert moving.n_frames == 3
        assert moving.size == (800, 416)
        first = np.asarray(moving.convert("RGB"))
        moving.seek(2)
        assert (np.asarray(moving.convert("RGB")) != first).any()


def test_what_cannot_be_drawn_is_refused(result, tmp_path):
    with pytest.raises(ArgumentError, match=r"run\.gif"):
        result.animate(tmp_path / "run.avi")
    with pytest.raises(ArgumentError, match="begin before the end"):
        result.animate(tmp_path / "run.gif", begin=3.0)
    if shutil.which("ffmpeg") is None:
        with pytest.raises(ArgumentError, match="ffmpeg"):
            result.animate(tmp_path / "run.mp4")
