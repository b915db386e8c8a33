# SPDX-License-Identifier: Apache-2.0
"""Broomstick: at the depth of the scene the soft string of `statics`, at others that of a shorter string."""

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.errors import ArgumentError, TableError
from drill_twin.studies.over_depth import broomstick, coefficients, over_depth_data, read_measured, shown

WELL = "wells/vertical_3000"


@pytest.fixture(scope="module")
def found():
    return dt.statics_over_depth("wells/s_shaped", [0.15, 0.25, 0.35], depths=6)


def test_at_the_depth_of_the_scene_it_is_the_soft_string_of_statics(found):
    whole = dt.statics("wells/s_shaped", {"effects.wall_friction.coefficient": 0.25})
    for rows, operation in zip(found.hookload, found.operations, strict=True):
        assert rows[1, -1] == pytest.approx(whole[operation.name].soft.hookload, rel=1e-9)
    assert found.torque[1, -1] == pytest.approx(whole["off bottom"].soft.surface_torque, rel=1e-9)
    assert (np.diff(found.hookload[0], axis=0) >= 0.0).all()
    assert (np.diff(found.hookload[1], axis=0) <= 0.0).all()


def test_in_a_vertical_hole_it_is_the_weight_of_what_hangs():
    hanging = dt.statics_over_depth(WELL, [0.2], depths=2)
    assert hanging.torque == pytest.approx(0.0, abs=1e-6)
    assert np.ptp(hanging.hookload[:, 0], axis=0) == pytest.approx(0.0, abs=1e-6)
    pipe = hanging.scene.string.sections[-1]
    below = hanging.hookload[0, 0]
    assert 0.9 * 1500.0 * pipe.mass_per_length * 9.81 * 0.8 < below[1] - below[0] < 1500.0 * pipe.mass_per_length * 9.81


def test_measured_points_mean_their_friction(found, tmp_path):
    at = [2, 4]
    rows = [
        (found.depth[k], found.hookload[0, 1, k] / 1e3, found.hookload[1, 1, k] / 1e3, found.torque[1, k] / 1e3)
        for k in at
    ]
    file = tmp_path / "measured.csv"
    np.savetxt(file, rows, delimiter=",", header="bit depth [m],pick-up [kN],slack-off [kN],torque [kN.m]", comments="")
    points = read_measured(file)
    data = over_depth_data(found, points)
    for of in ("trip out", "trip in", "torque"):
        assert data["measured"][of]["friction"] == pytest.approx([0.25, 0.25], abs=1e-6)
    assert "measured trip in: friction 0.25 (median of 2" in "\n".join(map(str, shown(found, points)))
    assert len(broomstick(found, points).axes) == 2


def test_rows_with_weight_on_bit_are_left_out_and_counted(found, tmp_path):
    """Torque measured while drilling has that of the bit in it."""
    at, torque = found.depth[4], found.torque[1, 4] / 1e3
    file = tmp_path / "measured.csv"
    file.write_text(f"bit depth [m],WOB [kN],torque [kN.m]\n{at},0.4,{torque}\n{at},90,{torque + 3}\n{at},,{torque}\n")
    points = read_measured(file)
    assert points["torque"].value == pytest.approx([1e3 * torque] * 2)
    said = "\n".join(map(str, shown(found, points)))
    assert "measured torque: friction 0.25 (median of 2" in said
    assert "measured torque: 1 rows with more than 5 kN on the bit left out" in said


def test_what_is_no_measurement_is_left_out_and_counted(found, tmp_path):
    at, load = found.depth[4], found.hookload[0, 1, 4] / 1e3
    cells = (load, "-999.25", "", "#N/A", "-999", -25e3, load)  # kN; no rig has a hookload of -25 MN
    file = tmp_path / "measured.csv"
    file.write_text("bit depth [m],pick-up [kN]\n" + "".join(f"{at},{cell}\n" for cell in cells) + f"-999.25,{load}\n")
    points = read_measured(file)
    assert points["trip out"].value == pytest.approx([1e3 * load] * 2)
    told = over_depth_data(found, points)["measured"]["trip out"]["left_out"]
    assert told == (
        "bit depth [m] 1 of -999.25 (row 8); pick-up [kN] 2 without a number (rows 3 to 4), 1 of -999.25 (row 2), "
        "1 beyond any hookload (row 6), 1 of -999 (row 5)"
    )
    said = "\n".join(map(str, shown(found, points)))
    assert f"measured trip out: left out, {told}" in said
    assert "median of 2" in said


def test_what_is_no_range_and_no_record_over_depth_is_refused(tmp_path):
    assert coefficients("0.15..0.35:5") == pytest.approx([0.15, 0.2, 0.25, 0.3, 0.35])
    assert coefficients("0.3,0.2") == [0.2, 0.3]
    for text in ("0.1..", "-0.1..0.3", "0.1..0.3:0", "many", "0.1..9:3"):
        with pytest.raises(ArgumentError, match=r"--friction: expected (at most 20 coefficients|LO\.\.HI)"):
            coefficients(text)
    file = tmp_path / "rig.csv"
    file.write_text("time [s],RPM [rpm]\n0,1\n1,2\n")
    with pytest.raises(TableError, match="expected a column of depth and a column of a load"):
        read_measured(file)
