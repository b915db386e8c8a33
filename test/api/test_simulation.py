# SPDX-License-Identifier: Apache-2.0
"""Runs in Python: bit for bit those of a session, in memory as on disk, and a controller in the loop."""

import math
import re

import numpy as np
import pytest
from summaries import summarise

import drill_twin as dt
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, OF_EVERY_RUN, REALTIME_FACTOR, TWIN_SCENE, TWIN_SUMMARY
from drill_twin.report.figures import FIGURES
from drill_twin.report.run_log import RunLog

TEXTS = {TWIN_SCENE, DIAGNOSTICS, REALTIME_FACTOR}
"""Topics that hold wall-clock times."""


@pytest.fixture(scope="module")
def result(bench_scene):
    return dt.Simulation(bench_scene).run()


def recorded(bag):
    return [
        (topic, stamp, raw[:-16] if topic == TWIN_SUMMARY else raw)  # the last number is the real-time factor
        for topic, stamp, raw in bag.messages()
        if topic not in TEXTS
    ]


def test_a_run_in_memory_has_the_messages_of_a_session(result, bench_run, tmp_path):
    written = Bag(result.to_bag(tmp_path / "bag_0"))
    assert recorded(written) == recorded(Bag(bench_run.bag))
    assert {name for name, topic in written.topics.items() if topic.count} == set(OF_EVERY_RUN)


def test_a_bag_gives_the_same_result(result, bench_run):
    same = dt.read_bag(bench_run.bag)
    for group, name in (("marks", "position"), ("string", "position"), ("rig", "hookload"), ("set_points", "rotation"),
                        ("whirl", "orbit_radius")):  # fmt: skip
        assert np.array_equal(getattr(getattr(same, group), name), getattr(getattr(result, group), name)), group
    assert same.onset_s == result.onset_s == bench_run.summary.onset_s
    assert same.summary["motion"] == result.summary["motion"]
    assert same.summary == summarise(bench_run.bag)
    assert dt.read_bag(bench_run.bag, begin=1.0, end=2.0).time.tolist() == [t for t in same.time if 1.0 <= t <= 2.0]


def test_arrays_have_the_documented_shapes(result, bench_scene):
    samples, marks, nodes = 300, len(bench_scene.string.marks), 9
    assert result.time.shape == (samples,)
    assert result.marks.names == tuple(mark.name for mark in bench_scene.string.marks)
    assert result.marks.position.shape == result.marks.wall_force.shape == (samples, marks, 3)
    assert result.centre.shape == (samples, marks, 2)
    assert result.wall_force.shape == result.whirl.precession.shape == (samples, marks)
    assert result.string.position.shape == result.string.tangent.shape == (samples, nodes, 3)
    assert result.string.spin.shape == (samples, nodes)
    for values in (result.hookload, result.torque, result.bit_torque, result.weight_on_bit, result.string.time,
                   result.set_points.weight_on_bit, result.whirl.time):  # fmt: skip
        assert values.shape == (samples,)
    assert result.weight_on_bit[-1] == pytest.approx(100.0)
    assert result.set_points.rotation[-1] == pytest.approx(4.0 * math.pi)
    assert result.cost.elements == 8
    assert result.cost.steps > samples
    assert result.energy == {}
    assert re.fullmatch(r"<Result of pa6_bench: 300 samples to 3 s, whirl before 0\.\d\d s>", repr(result))


def test_wall_forces_push_a_mark_to_the_axis(result):
    touching = result.wall_force > 1e-3
    assert touching.any()
    inwards = np.einsum("tmk,tmk->tm", result.marks.wall_force[..., :2], result.centre)
    assert (inwards[touching] < 0.0).all()


def test_a_controller_is_in_the_loop(bench_scene):
    simulation = dt.Simulation(bench_scene)
    state = simulation.advance(wob="20 N", rpm=60)
    assert state.time == pytest.approx(0.01)
    while state.time < 0.5:
        state = simulation.advance(wob=min(state.weight_on_bit + 5.0, 60.0), seconds=0.1)
    result = simulation.result()
    assert result.time[-1] == pytest.approx(0.51)
    sent = result.set_points
    assert sent.weight_on_bit[[0, 1, 11, 21, 31, 41]].tolist() == pytest.approx([20.0, 25.0, 30.0, 35.0, 40.0, 45.0])
    assert (sent.rotation == 2.0 * math.pi).all()
    assert state.rpm == pytest.approx(60.0)
    assert state.centre.shape == (4, 3)
    assert state.hookload == result.hookload[-1]
    simulation.run(duration="0.1 s")
    assert simulation.time == pytest.approx(0.61)
    assert result.time.size == 51, "a result does not change when the run goes on"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.advance(wob="40 kg"), 'wob: expected a force such as "40 N"'),
        (lambda s: s.advance(rpm=math.nan), "rpm: expected a speed of rotation"),
        (lambda s: s.advance(seconds=0.013), r"whole number of frames of 0.01 s, found 0.013; take 0.01"),
        (lambda s: s.advance(seconds=-1), "seconds: expected a time above 0 s"),
        (lambda s: s.run(duration=0), "duration: expected a time above 0 s"),
        (lambda s: s.advance(rpm=7000), "rpm: expected -6000 to 6000 rpm, found 7000 rpm"),
        (lambda s: s.result(), "at least one frame"),
    ],
)
def test_arguments_are_refused_in_words(bench_scene, call, words):
    simulation = dt.Simulation(bench_scene)
    with pytest.raises(dt.ArgumentError, match=words):
        call(simulation)


def test_a_scene_at_its_end_asks_for_a_duration(bench_scene):
    simulation = dt.Simulation(bench_scene, {"duration": 0.02})
    simulation.run()
    with pytest.raises(dt.ArgumentError, match="at its end"):
        simulation.run()
    short = dt.Simulation(bench_scene, {"duration": 1e-4})
    with pytest.raises(
        dt.ArgumentError, match=r"rig\.duration: expected at least half a frame .*; run for longer \(--dur"
    ):
        short.run()


def test_figures_are_those_of_the_report_and_show_in_a_notebook(result):
    names = [name for name in dir(result) if name.startswith("plot_")]
    assert {name.removeprefix("plot_") for name in names} == set(FIGURES)
    for name in names:
        figure = getattr(result, name)()
        assert figure.get_axes()
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_dataset_has_units_and_names(result):
    xarray = pytest.importorskip("xarray")
    data = result.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert data["mark_position"].dims == ("time", "mark", "axis")
    assert data["hookload"].attrs["units"] == "N"
    picked = data["orbit_radius"].sel(mark="mark_2").to_numpy()
    assert np.array_equal(picked, result.whirl.orbit_radius[:, 1])
    assert data.attrs["onset_s"] == result.onset_s


def test_without_xarray_the_remedy_is_named(result, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "xarray", None)
    with pytest.raises(dt.ArgumentError, match=re.escape("pip install 'drill_twin[xarray]'")):
        result.to_xarray()


def test_a_run_that_cannot_go_on_keeps_what_came_before(bench_scene):
    simulation = dt.Simulation(bench_scene)
    simulation.advance(wob=40, rpm=120, seconds=0.1)
    with pytest.raises(dt.RunError) as stopped:
        simulation.advance(wob=1e6, seconds=1.0)
    result = simulation.result()
    assert 10 <= result.time.size < 20
    assert result.time[-1] == pytest.approx(simulation.time)
    assert result.summary["guard"]["stopped"] == str(stopped.value)


def test_the_energy_balance_is_read_report_by_report():
    log = RunLog()
    for stamp, kinetic in ((1, 0.5), (2, 0.75), (2, 0.75)):
        values = {"realtime_factor": "10", "energy_stored_kinetic_J": repr(kinetic), "energy_residual": "1e-9"}
        status = Status("simulator", Level.OK, "", values)
        log.on_diagnostics(encode_diagnostics(stamp * 1_000_000_000, [status]))
    assert {key: values.tolist() for key, values in log.energy.items()} == {
        "time": [1.0, 2.0], "stored_kinetic_J": [0.5, 0.75], "residual": [1e-9, 1e-9]
    }  # fmt: skip
