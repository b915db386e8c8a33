# SPDX-License-Identifier: Apache-2.0
"""Lines that people write: short arguments, findings by attribute, marks by name, a part of a run by time."""

import math

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.core.errors import ArgumentError


@pytest.fixture(scope="module")
def result():
    return dt.Simulation("pa6_bench").run(duration=9)


def test_a_scene_takes_its_short_keys_as_arguments():
    scene = dt.load_scene("pa6_bench", {"hole.radius": "85 mm", "wob": 10}, wob="60 N", rpm=90)
    assert (scene.rig.weight_on_bit.value, scene.hole.radius) == (60.0, 0.085)
    assert scene.rig.rotation.value == pytest.approx(3.0 * math.pi)
    with pytest.raises(dt.SceneError, match=r'force such as "40 N", found "60 s"'):
        dt.load_scene("pa6_bench", wob="60 s")
    with pytest.raises(dt.SceneError, match='found "weight"'):
        dt.load_scene("pa6_bench", weight=3)


def test_the_onset_is_one_wherever_it_is_asked_for(result):
    assert result.onset_s == result.onset.time_s == result.whirl.onset_s == result.summary.onset_s
    assert result.onset == result.whirl.onset
    assert result.summary["onset_mark"] == result.onset.mark
    with pytest.raises(AttributeError, match='did you mean "onset_s"'):
        _ = result.summary.onset_ss


def test_channels_of_the_rig_have_short_names(result):
    assert np.array_equal(result.bit_speed, result.rig.bit_speed)
    assert result.rpm[-1] == pytest.approx(120.0, rel=1e-6)


def test_a_mark_is_found_by_its_name(result):
    mark = result.marks["mark_2"]
    assert np.array_equal(mark.time, result.marks.time)
    for column in ("position", "spin", "velocity", "spin_rate", "wall_force"):
        assert np.array_equal(getattr(mark, column), getattr(result.marks, column)[:, 1])
    with pytest.raises(ArgumentError, match='did you mean "mark_2"'):
        _ = result.marks["mark2"]


def test_a_part_is_selected_by_time_and_analysed_by_itself(result):
    part = result.sel(time=slice("2 s", 4))
    assert part.time[[0, -1]].tolist() == [2.0, 4.0]
    whole = (result.time >= 2.0) & (result.time <= 4.0)
    assert np.array_equal(part.hookload, result.hookload[whole])
    assert part.onset is None
    assert result.onset_s > 4.0  # which the part does not reach
    assert part.scene == result.scene
    assert part.sel(time=slice(None, 3)).time[[0, -1]].tolist() == [2.0, 3.0]
    assert part.sel(time=slice(0, None)).time[0] == 2.0  # a part of a part has no more


def test_whirl_that_a_part_begins_with_is_said_to_have_begun_before(result):
    part = result.sel(time=slice(result.onset_s + 1.0, None))
    assert part.onset.at_start
    assert f"whirl before {part.onset_s:.2f} s" in repr(part)
    assert f"whirl from {result.onset_s:.2f} s" in repr(result)


@pytest.mark.parametrize("time", [5.0, slice(5, 4), slice(0, 5, 2), slice("5 kg", None)])
def test_a_time_that_is_no_part_is_refused(result, time):
    with pytest.raises(ArgumentError, match="time: expected"):
        result.sel(time=time)


def test_a_time_beyond_the_run_is_refused(result):
    with pytest.raises(dt.BagError, match="expected marks and rig states"):
        result.sel(time=slice(100, 110))


def test_a_scene_is_shown_on_one_screen(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    scene = dt.load_scene("wells/s_shaped")
    lines = str(scene).splitlines()
    assert repr(scene) == str(scene)
    assert len(lines) < 25
    assert max(map(len, lines)) <= 80
    assert lines[0] == "s_shaped: Well plan"
    assert lines[1].split(maxsplit=1) == ["string", "3000 m, 5 sections, bit end pinned"]
    assert "<th>weight on bit</th><td>100 kN</td>" in scene._repr_html_()


def test_whirl_is_shown_by_its_findings(result):
    shown = " ".join(str(result.whirl).split())
    assert f"onset of whirl {result.onset_s:.2f} s, first at {result.onset.mark}" in shown
    assert "mark_2 0.08" in shown
    calm = dt.analyze(result.time, *(0.0 * result.centre[:, 0].T), "120 rpm", clearance="80 mm")
    assert "onset of whirl none found" in " ".join(repr(calm).split())


def test_a_result_is_a_line_and_its_findings_in_a_notebook(result):
    assert len(repr(result).splitlines()) == 1
    page = result._repr_html_()
    assert f"whirl from {result.onset_s:.2f} s&gt;" in page
    assert "<th>severity" in page


def test_a_run_and_an_ensemble_tell_what_they_are():
    simulation = dt.Simulation("pa6_bench")
    assert repr(simulation) == "<Simulation of pa6_bench: 0 s, not begun>"
    simulation.advance(wob=10, rpm=60, seconds=0.5)
    assert repr(simulation).startswith("<Simulation of pa6_bench: 0.5 s, ")
    ensemble = dt.Ensemble("pa6_bench", {"wob": ["10 N", 40], "seed": range(3)})
    assert repr(ensemble) == "<Ensemble of pa6_bench: 6 members, 2 of wob x 3 of seed>"
    zipped = dt.Ensemble("pa6_bench", {"wob": ["10 N", 60], "rpm": [60, 90]}, zipped=True).run(0.5, workers=1)
    assert repr(zipped) == "<EnsembleResult of pa6_bench: 2 members, 2 of wob with 2 of rpm>"
    assert "<th>onset_s</th><td>s</td>" in zipped._repr_html_()


def test_a_result_draws_and_reports_itself(result, tmp_path):
    assert result.plot().axes[0].get_ylabel() == result.plot_displacement().axes[0].get_ylabel()
    assert result.plot("orbits").get_suptitle() == result.plot_orbits().get_suptitle()
    with pytest.raises(ArgumentError, match='did you mean "orbits"'):
        result.plot("orbit")
    page = result.report(tmp_path / "report")
    assert page == tmp_path / "report" / "report.html"
    assert (tmp_path / "report" / "orbits.png").stat().st_size > 10_000
    assert f"{result.onset_s:.2f} s" in page.read_text("utf-8")


def test_a_run_without_marks_draws_what_it_has():
    scene = dt.build_scene("bare", base="pa6_bench", string={"marks": []})
    result = dt.Simulation(scene).run(duration=0.5)
    assert result.plot().axes[0].get_ylabel() == result.plot_set_points().axes[0].get_ylabel()
    with pytest.raises(ArgumentError, match="no positions of marks"):
        result.plot_orbits()


def test_modes_draw_and_show_themselves(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    table = dt.modes("pa6_bench", {"wob": 5}, count=3, is_compared=False)
    lines = str(table).splitlines()
    assert len(lines) < 20
    assert lines[0].startswith("pa6_bench: 5 N at 2 rev/s, string on the axis.")
    assert any(line.split()[:2] == ["lateral", "1"] for line in lines)
    panels = table.plot().axes
    assert len(panels) == 3
    assert panels[0].get_title(loc="left").startswith(f"lateral 1\n{table.modes[0].frequency:+.3g} Hz\n")


def test_speeds_are_a_range_with_its_unit_or_numbers_in_si():
    turns = np.linspace(1.0, 3.0, 5)
    diagram = dt.campbell("pa6_bench", speeds="60..180:5 rpm", count=3)
    assert np.allclose(diagram.speeds, math.tau * turns, rtol=1e-12)
    same = dt.campbell("pa6_bench", speeds=list(math.tau * turns), count=3)
    assert np.allclose(diagram.eigenvalues, same.eigenvalues, rtol=1e-9)
    assert "1 to 3 rev/s" in str(diagram)
    assert str(diagram).startswith("pa6_bench: lateral modes at 40 N")
    assert [line.get_xdata()[-1] for line in diagram.plot().axes[0].lines[:3]] == pytest.approx([3.0] * 3)
    growth = dt.growth_map("pa6_bench", weights="0..20:2 N", speeds="60..120:2 rpm")
    assert growth.lateral.shape == (2, 2)
    assert growth.plot().axes[0].get_ylabel() == "weight on bit [N]"
    for speeds in ("60..180", "60..180 N", [2.0, 1.0]):
        with pytest.raises(ArgumentError, match="speeds: expected"):
            dt.campbell("pa6_bench", speeds=speeds)


def test_statics_draw_and_show_themselves():
    loads = dt.statics("pa6_bench")
    assert all(name in str(loads) for name in ("hookload", "off bottom", "drill"))
    assert [axes.get_title(loc="left") for axes in loads.plot().axes][:2] == ["tension", "torque"]
    assert loads["drill"].hookload == pytest.approx(loads.operations[-1].hookload)


def test_states_compare_with_their_text(result):
    state = result.whirl.summary.motion[-1].state
    assert state == state.value == result.whirl.motion[-1]["state"]
    assert result.summary.lasting_motion == result.whirl.summary.lasting_motion
    assert dt.MotionState.FORWARD_WHIRL == "forward whirl"
    assert dt.Regime.SMOOTH == "smooth"
    assert f"{dt.MotionState.SPIRAL}" == "spiral"
