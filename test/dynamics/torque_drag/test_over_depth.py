# SPDX-License-Identifier: Apache-2.0
"""Broomstick: at the depth of the scene the soft string of `statics`, at others that of a shorter string."""

from functools import cache

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.errors import ArgumentError, TableError
from drill_twin.dynamics.torque_drag.along_string import hole_and_string
from drill_twin.dynamics.torque_drag.over_depth import OverDepth
from drill_twin.dynamics.torque_drag.soft_string import soft_string
from drill_twin.studies.over_depth import (
    Points,
    broomstick,
    coefficients,
    fits_of,
    over_depth_data,
    read_measured,
    shown,
)

WELL = "wells/vertical_3000"
COARSE = {"numerics.elements": "100"}
"""Elements enough for the soft string of `s_shaped`, and a fraction of those that its motion takes."""


def said_of(found, points, fits):
    return "\n".join(one if isinstance(one, str) else one.text() for one in shown(found, points, fits))


@pytest.fixture(scope="module")
def found():
    return dt.statics_over_depth("wells/s_shaped", [0.15, 0.25, 0.35], COARSE, depths=6)


@pytest.mark.slow
def test_at_the_depth_of_the_scene_it_is_the_soft_string_of_statics(found):
    whole = dt.statics("wells/s_shaped", {"effects.wall_friction.coefficient": 0.25, **COARSE})
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
    fits = fits_of(found, points)
    data = over_depth_data(found, points, fits)
    for of in ("trip out", "trip in", "torque"):
        assert list(data["measured"][of]["friction"].values()) == pytest.approx([0.25], abs=1e-3)
        assert data["measured"][of]["points_outside_of_curves"] == 0
    assert "measured trip in: friction cased and open hole 0.25 +- " in said_of(found, points, fits)
    assert len(broomstick(found, points, fits).axes) == 2


def test_rows_with_weight_on_bit_are_left_out_and_counted(found, tmp_path):
    """Torque measured while drilling has that of the bit in it."""
    at, torque = found.depth[4], found.torque[1, 4] / 1e3
    file = tmp_path / "measured.csv"
    file.write_text(f"bit depth [m],WOB [kN],torque [kN.m]\n{at},0.4,{torque}\n{at},90,{torque + 3}\n{at},,{torque}\n")
    points = read_measured(file)
    assert points["torque"].value == pytest.approx([1e3 * torque] * 2)
    said = said_of(found, points, fits_of(found, points))
    assert "measured torque: friction cased and open hole 0.25 +- 0 (least squares, 2 points" in said
    assert "measured torque: 1 rows with more than 5 kN on the bit left out" in said


def test_what_is_no_measurement_is_left_out_and_counted(found, tmp_path):
    at, load = found.depth[4], found.hookload[0, 1, 4] / 1e3
    cells = (load, "-999.25", "", "#N/A", "-999", -25e3, load)  # kN; no rig has a hookload of -25 MN
    file = tmp_path / "measured.csv"
    file.write_text("bit depth [m],pick-up [kN]\n" + "".join(f"{at},{cell}\n" for cell in cells) + f"-999.25,{load}\n")
    points = read_measured(file)
    assert points["trip out"].value == pytest.approx([1e3 * load] * 2)
    fits = fits_of(found, points)
    told = over_depth_data(found, points, fits)["measured"]["trip out"]["left_out"]
    assert told == (
        "bit depth [m] 1 of -999.25 (row 8); pick-up [kN] 2 without a number (rows 3 to 4), 1 of -999.25 (row 2), "
        "1 beyond any hookload (row 6), 1 of -999 (row 5)"
    )
    said = said_of(found, points, fits)
    assert f"measured trip out: left out, {told}" in said
    assert "2 points" in said


@pytest.mark.parametrize("load", [0.0, -3.0])
def test_a_hookload_of_nothing_is_refused_with_its_row(found, tmp_path, load):
    file, at = tmp_path / "measured.csv", found.depth[4]
    file.write_text(f"bit depth [m],pick-up [kN],torque [kN.m]\n{at},400,0\n{at},,1\n{at},{load},2\n")
    with pytest.raises(TableError, match=rf"above 0 in 'pick-up \[kN\]', found {1e3 * load:g} N in row 3; empty it"):
        read_measured(file)
    file.write_text(file.read_text().replace(f"{at},{load},2", f"{at},,2"))
    assert read_measured(file)["torque"].value.tolist() == [0.0, 1e3, 2e3]


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


CASED, OPEN = 0.18, 0.34
NOISE = {"trip out": 6e3, "trip in": 6e3, "torque": 400.0}
"""Standard deviations of the loads of made-up trips [N], [N m]."""


@cache
def rubbing(cased: float, uncased: float) -> OverDepth:
    """Well `s_shaped` with a coefficient in its casing and another below it."""
    change = {
        **COARSE,
        "effects.wall_friction.coefficient": uncased,
        "effects.wall_friction.intervals": [{"top": "0 m", "bottom": "1500 m", "coefficient": cased}],
    }
    return dt.statics_over_depth("wells/s_shaped", [0.2], change, depths=1)


def trip(cased: float, uncased: float, load: str, depth: np.ndarray) -> np.ndarray:
    """Loads of a string that is run with a coefficient in the casing of `s_shaped` and another below it."""
    own = rubbing(cased, uncased)
    operation = own.curves(load)[1]
    strings = (hole_and_string(own.equations.scene, own.equations.model, bit) for bit in depth.tolist())
    loads = [soft_string(string, operation) for string in strings]
    return np.array([one.surface_torque if load == "torque" else one.hookload for one in loads])


@pytest.mark.slow
@pytest.mark.parametrize("load", ["trip out", "trip in", "torque"])
def test_two_factors_of_made_up_trips_are_found_within_their_errors(found, load):
    """Errors hold in 95 of 100 trips with noise: fits of four agree with linear least squares, which make 500 trips."""
    depth = np.linspace(900.0, 2950.0, 14)
    truth, step = trip(CASED, OPEN, load, depth), 0.02
    slopes = np.column_stack([trip(CASED + step, OPEN, load, depth), trip(CASED, OPEN + step, load, depth)])
    slopes = (slopes - truth[:, None]) / step
    spread = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))

    def linear(noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        change, squares, *_ = np.linalg.lstsq(slopes, noise, rcond=None)
        return change, 2.179 * np.sqrt(squares[0] / 12.0) * spread  # Student's t of 12 degrees of freedom at 97.5 %

    noises = np.random.default_rng(5).normal(0.0, NOISE[load], (500, depth.size))
    held = np.mean([abs(change) <= error for change, error in map(linear, noises)], axis=0)
    assert held == pytest.approx(0.95, abs=0.03)
    for noise in noises[:4]:
        fit = found.fit(load, depth, truth + noise)
        change, error = linear(noise)
        assert fit.parts == ("cased", "open")
        assert fit.friction - [CASED, OPEN] == pytest.approx(change, abs=0.1 * error.max())
        assert fit.error == pytest.approx(error, rel=0.1)
    exact = found.fit(load, depth, truth)
    assert exact.friction == pytest.approx([CASED, OPEN], abs=2e-3)
    deep = [one for one in exact.trend if one.top > 1600.0]
    assert len(deep) >= 2
    assert [one.friction for one in deep] == pytest.approx([OPEN] * len(deep), abs=5e-3)
    assert exact.trend[0].part == "cased"


def test_a_truth_beyond_the_curves_is_fitted_and_not_censored(found):
    """All of the deep points lie beyond the curves of 0.15 to 0.35; a median of the points inside would be below."""
    depth = np.linspace(900.0, 2950.0, 14)
    loads = trip(0.25, 0.6, "trip out", depth) + np.random.default_rng(7).normal(0.0, 6e3, depth.size)
    fit = found.fit("trip out", depth, loads)
    assert fit.beyond > 6
    assert abs(fit.friction[1] - 0.6) <= fit.error[1] < 0.1
    file_points = {"trip out": Points(depth, loads)}
    said = said_of(found, file_points, fits_of(found, file_points))
    assert f"{fit.beyond} points outside of the curves, counted; outside of --friction, 0.15 to 0.35" in said


@pytest.mark.slow
def test_where_cased_and_open_cannot_be_told_apart_it_is_said(found):
    """Points in the casing tell its factor only; points near one depth only the factor that both have together."""
    shallow, near = np.linspace(700.0, 1490.0, 9), np.linspace(2900.0, 2950.0, 9)
    noise = np.random.default_rng(3).normal(0.0, 6e3, 9)
    cased = found.fit("trip out", shallow, trip(CASED, OPEN, "trip out", shallow) + noise)
    assert cased.parts == ("cased",)
    assert abs(cased.friction[0] - CASED) <= cased.error[0]
    loads = trip(CASED, OPEN, "trip out", near) + noise
    both = found.fit("trip out", near, loads)
    assert both.parts == ("both",)
    assert CASED < both.friction[0] < OPEN
    points = {"trip out": Points(near, loads), "trip in": Points(shallow, trip(0.2, 0.3, "trip in", shallow))}
    said = said_of(found, points, fits_of(found, points))
    assert "these points cannot tell cased from open: errors of" in said
    assert "measured trip in: friction cased 0.2 +- " in said
    assert "no point tells the open hole" in said


def test_loads_of_a_vertical_well_tell_no_friction():
    hanging = dt.statics_over_depth(WELL, [0.2, 0.3], depths=3)
    points = {"trip out": Points(hanging.depth, hanging.hookload[0, 0])}
    fits = fits_of(hanging, points)
    assert "no load of these 3 points depends on friction" in said_of(hanging, points, fits)
    assert over_depth_data(hanging, points, fits)["measured"]["trip out"]["friction"] == {}


def test_points_below_the_string_are_refused(found):
    points = {"trip out": Points(np.array([1000.0, 3050.0]), np.array([4e5, 9e5]))}
    with pytest.raises(ArgumentError, match=r"--measured: expected depths of the bit up to 3000 m, found 3050 m"):
        fits_of(found, points)


def test_a_single_point_has_a_factor_without_an_error(found):
    points = {"trip out": Points(np.array([2500.0]), trip(0.3, 0.3, "trip out", np.array([2500.0])))}
    said = said_of(found, points, fits_of(found, points))
    assert "friction cased and open hole 0.3, error not known (least squares, 1 points" in said


@pytest.mark.long
def test_a_factor_at_its_bound_has_the_error_of_the_linear_problem(found):
    """Noise of 1 % takes the factor of a smooth casing below 0; the derivative there tells its error."""
    depth = np.linspace(900.0, 2950.0, 14)
    base = trip(0.0, 0.25, "trip out", depth)
    slopes = (trip(0.01, 0.25, "trip out", depth) - base, trip(0.0, 0.26, "trip out", depth) - base)
    spread = np.linalg.inv(1e4 * np.array(slopes) @ np.array(slopes).T)
    bound = 0
    for seed in range(8):
        loads = base * (1.0 + 0.01 * np.random.default_rng(seed).normal(size=depth.size))
        fit = found.fit("trip out", depth, loads)
        if fit.parts != ("cased", "open") or fit.friction[0] > 0.0:
            assert fit.apart.size or fit.friction[0] > 1e-4
            continue
        bound += 1
        scatter = 2.179 * np.sqrt(fit.residual @ fit.residual / 12.0)
        assert fit.error == pytest.approx(scatter * np.sqrt(np.diag(spread)), rel=0.1)
        assert fit.error[0] > 0.015
        points = {"trip out": Points(depth, loads)}
        assert "friction cased 0 (at its bound) +- 0.0" in said_of(found, points, {"trip out": fit})
    assert bound >= 2


def test_a_fit_takes_lists(found):
    depth, load = found.depth[3:].tolist(), found.hookload[0, 1, 3:].tolist()
    assert found.fit("trip out", depth, load).friction == pytest.approx([0.25, 0.25], abs=0.01)


NAN = float("nan")


@pytest.mark.parametrize(
    ("load", "depth", "measured", "words"),
    [
        ("tripout", [1e3, 2e3], [5e5, 6e5], 'trip out, trip in, off bottom, torque, found "tripout", did you mean'),
        ("trip out", [1e3, NAN], [5e5, 6e5], "depths .*expected finite numbers from 0 to 3000, found nan"),
        ("trip out", [1e3, 2e3], [5e5, NAN], "loads, trip out: expected finite numbers .*found nan"),
        ("torque", [1e3, 2e3], [5e5, NAN], "loads, torque: expected finite numbers .*found nan"),
        ("trip out", [1e3, 2e3], [5e5, 0.0], "loads, trip out: .* found 0"),
        ("trip in", [1e3, 2e3], [5e5, -2e3], "loads, trip in: .* found -2000"),
        ("trip out", [1e3, 4e3], [5e5, 6e5], "depths .*to 3000, found 4000"),
        ("trip out", [1e3, 2e3], [5e5], "a load a depth, found 1 loads and 2 depths"),
        ("trip out", [], [], r"depths .*found \[\]"),
        ("trip out", [[1e3]], [[5e5]], r"depths .*found \[\[1000"),
        ("trip out", ["deep"], [5e5], r"depths .*found \['deep'\]"),
    ],
)
def test_measured_loads_that_cannot_be_fitted_are_refused(found, load, depth, measured, words):
    with pytest.raises(ArgumentError, match=words):
        found.fit(load, depth, measured)


@pytest.mark.parametrize("friction", [[], [-0.1], [0.2, NAN], [6.0], 0.2, ["much"], None])
def test_friction_that_is_no_list_of_coefficients_is_refused(friction):
    with pytest.raises(ArgumentError, match=r"friction: expected finite numbers from 0 to 5, found"):
        dt.statics_over_depth("wells/s_shaped", friction)
    with pytest.raises(ArgumentError, match="depths: expected"):
        dt.statics_over_depth("wells/s_shaped", [0.2], depths=0)


def test_a_string_that_locks_is_neither_drawn_nor_fitted():
    """With friction of 2 the string holds in `s_shaped` from 1500 m on; points of 0.3 are fitted all the same."""
    found = dt.statics_over_depth("wells/s_shaped", [0.2, 2.0], COARSE, depths=4)
    assert np.isnan(found.hookload[1, 1]).tolist() == [False, True, True, True]
    assert np.isfinite(found.hookload[[0, 2]]).all()
    depth = np.linspace(1000.0, 2900.0, 6)
    points = {"trip in": Points(depth, trip(0.3, 0.3, "trip in", depth))}
    fits = fits_of(found, points)
    assert fits["trip in"].friction == pytest.approx([0.3] * len(fits["trip in"].parts), abs=5e-3)
    assert fits["trip in"].beyond == 0
    said = said_of(found, points, fits)
    assert "locked: friction holds the string" in " ".join(said.split())
    assert [line.split()[2] for line in said.splitlines() if line.split()[:1] == ["2"]] == ["locked"]
    assert over_depth_data(found, points, fits)["hookload_n"]["trip in"][1][1:] == [None] * 3
    lines = broomstick(found, points, fits).axes[0].lines
    assert min(np.nanmin(line.get_xdata()) for line in lines if len(line.get_xdata())) > -1e4  # [kN]
