# SPDX-License-Identifier: Apache-2.0
"""Members of an ensemble are single runs, bit for bit; one that fails stops no other."""

import re
import threading

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble import parts
from drill_twin.runs.ensemble import run as member_run
from drill_twin.runs.ensemble.outputs import Request, Spectra
from drill_twin.runs.ensemble.parts import frames_of, planned
from drill_twin.scene.set_points import Command

COARSE = {
    "numerics.elements": 8,
    "numerics.step": "10 ms",
    "rig.rotation.duration": 1.0,
    "rig.weight_on_bit.duration": 1.0,
}
DURATION = 4.0
VARY = {"wall_friction.coefficient": [0.1, 0.205], "wob": [20, 40]}
ALL = ("findings", "extremes", "contact", "marks", "spectra")


@pytest.fixture(scope="module")
def found():
    return dt.Ensemble("pa6_bench", VARY, overrides=COARSE).run(DURATION, outputs=ALL, mark_rate=100, workers=2)


@pytest.fixture(scope="module")
def single():
    """The last member as a run of its own: its states and its result."""
    states = []
    simulation = dt.Simulation("pa6_bench", {**COARSE, "effects.wall_friction.coefficient": 0.205, "wob": 40})
    return states, simulation.run(DURATION, progress=states.append)


def test_a_member_has_the_bits_of_a_single_run(found, single):
    states, result = single
    assert found.failed == {}
    assert np.array_equal(found["time"], result.time)
    assert np.array_equal(found["centre"][3], np.array([state.centre[:, :2] for state in states]))
    assert not np.array_equal(found["centre"][2], found["centre"][3])
    assert found.summaries[3].to_dict() == result.whirl.summary.to_dict()
    assert found["onset_s"][3] == result.onset_s is not None


def test_extremes_and_contact_are_those_of_the_states(found, single):
    states, result = single
    centre = np.array([state.centre for state in states])
    force = np.array([state.wall_force for state in states])
    assert np.array_equal(found["radius_max"][3], np.hypot(centre[..., 0], centre[..., 1]).max(axis=0))
    assert np.array_equal(found["wall_force_max"][3], force.max(axis=0))
    assert np.array_equal(found["contact_share"][3], (force > 0.0).mean(axis=0))
    assert 0.0 < found["string_contact_share"][3] < 1.0
    for name, values in (("torque", result.torque), ("bit_torque", result.bit_torque), ("hookload", result.hookload)):
        assert (found[f"{name}_max"][3], found[f"{name}_min"][3]) == (values.max(), values.min())


def test_chunks_change_nothing(found, monkeypatch):
    """Calls of 37 frames."""
    monkeypatch.setattr(parts, "CHUNK", 37)
    again = dt.Ensemble("pa6_bench", {"wob": [40]}, overrides=COARSE).run(DURATION, outputs=ALL, mark_rate=100)
    assert np.array_equal(again["centre"][0], found["centre"][3])
    assert again.summaries[0].to_dict() == found.summaries[3].to_dict()
    for name in ("spectrum", "radius_max", "contact_share", "torque_max"):
        assert np.array_equal(again[name][0], found[name][3])


def test_a_member_that_fails_is_reported_with_what_came_before():
    ensemble = dt.Ensemble("pa6_bench", {"wob": [20, 2e4, 40]}, overrides=COARSE)
    ended = []
    result = ensemble.run(1.0, outputs=("marks",), mark_rate=100, progress=lambda *count: ended.append(count))
    assert ended == [(1, 3), (2, 3), (3, 3)]
    assert list(result.failed) == [1]
    assert "could not be followed" in result.failed[1]
    assert "1 failed" in repr(result)
    frames = round(result.simulated[1] * 100)
    assert 0 < frames < 100
    assert np.isfinite(result["centre"][1, :frames]).all()
    assert np.isnan(result["centre"][1, frames:]).all()
    assert np.isfinite(result["centre"][[0, 2]]).all()


def test_marks_are_taken_at_their_rate(found):
    slow = dt.Ensemble("pa6_bench", {"wob": [40]}, overrides=COARSE).run(DURATION, outputs="marks", mark_rate="20 Hz")
    assert np.array_equal(slow["time"], found["time"][::5])
    assert np.array_equal(slow["centre"][0], found["centre"][3, ::5])


def test_a_circular_orbit_has_a_line_as_high_as_its_radius(found):
    twin = Twin(dt.load_scene("pa6_bench", COARSE))
    spectra = Spectra(twin, Request(("spectra",), 0.01, 4000, 1))
    rows = twin.record(1000, nodes=False).frames
    for chunk in range(4):
        time = (np.arange(1000) + 1000 * chunk) * 0.01
        turned = 2.0 * np.pi * 100.0 / 1024.0 * 16 * time
        rows.centre[..., 0] = 0.03 * np.cos(turned)[:, None] + 0.01
        rows.centre[..., 1] = -0.03 * np.sin(turned)[:, None]
        spectra.add(rows, None)
    values = spectra.close()
    line = int(np.argmax(values["spectrum"].value[:, 0]))
    assert values["spectrum"].value[line, 0] == pytest.approx(0.03, rel=1e-9)
    assert values["frequency"].value[line] == pytest.approx(-100.0 / 1024.0 * 16)  # backward
    assert found["spectrum"].shape == (4, 400, 4)


def test_a_dataset_has_the_values_as_coordinates(found):
    xarray = pytest.importorskip("xarray")
    data = found.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert data["onset_s"].dims == ("wall_friction.coefficient", "wob")
    picked = data["centre"].sel({"wall_friction.coefficient": 0.205, "wob": 20}).to_numpy()
    assert np.array_equal(picked, found["centre"][2])
    assert data["radius_max"].attrs["units"] == "m"
    zipped = dt.Ensemble("pa6_bench", {"seed": [1, 2], "wob": ["10 N", "20 N"]}, zipped=True, overrides=COARSE)
    data = zipped.run(0.1).to_xarray()
    assert data["radius_max"].dims == ("member", "mark")
    assert data["wob"].to_numpy().tolist() == [10.0, 20.0]


def test_a_table_has_a_row_for_each_member():
    pytest.importorskip("pandas")
    vary = {"wob": [10, "20 N"], "rpm": ["2 rev/s", 60]}
    table = (
        dt.Ensemble("pa6_bench", vary, overrides=COARSE).run(0.1, outputs=("findings", "extremes", "marks")).to_pandas()
    )
    assert table["wob"].tolist() == [10, 10, 20, 20]
    assert table["rpm"].tolist() == [120, 60, 120, 60]
    assert table["motion"].tolist() == ["unknown"] * 4
    assert {"failed", "onset_s [s]", "mark_1/radius_max [m]"} < set(table)
    assert not [name for name in table if name.startswith(("centre", "time"))]


def test_the_loop_leaves_python_free_while_it_runs():
    twin = Twin(dt.load_scene("pa6_bench", COARSE))
    twin.advance(Command(0.0, 1.0), 0.01)
    commands, rows = np.tile((20.0, 6.0, 0.0), (2000, 1)), twin.record(2000, nodes=False)
    thread = threading.Thread(target=twin.advance_frames, args=(commands, 0.01, rows))
    thread.start()
    turns = 0
    while thread.is_alive():
        turns += 1
    assert turns > 1000
    assert rows.frames.time[-1] == pytest.approx(20.01)


def test_the_energy_balance_is_an_output_of_audited_scenes():
    off = dict.fromkeys(("effects.stretch", "effects.torsion", "effects.bit_friction"), "off")
    audited = {**COARSE, **off, "numerics.audit": "energy"}  # a kernel that test/dynamics/audit compiles too
    found = dt.Ensemble("pa6_bench", {"wob": [40]}, overrides=audited).run(0.5, outputs="energy")
    single = dt.Simulation("pa6_bench", {**audited, "wob": 40})
    twin = Twin(single.scene)
    for command in [single.schedule.at(k / 100) for k in range(1, 51)]:
        frame = twin.advance(command, 0.01)
    assert found["energy_residual"][0] == frame.energy.share
    assert found["energy_dissipated_drag"][0] == frame.energy.dissipated["drag"] != 0.0


@pytest.mark.parametrize(
    ("vary", "more", "text"),
    [
        ({}, {}, "vary: expected at least one key with its values, found none"),
        ({"wob": []}, {}, "wob: expected at least one value, found none"),
        ({"wob": 40}, {}, "wob: expected a list of values, found 40; write [40] for a single one"),
        ({"wob": [float("nan")]}, {}, "wob: expected finite numbers or texts with a unit, found nan"),
        ({"wob": [1, 2], "seed": [1]}, {"zipped": True}, "found 2 of wob, 1 of seed"),
        ({"wob": range(2000), "seed": range(2000)}, {}, "expected at most 1000000 members, found 4000000"),
        ({"effects.drag": [True]}, {}, "expected finite numbers or texts with a unit, found True"),
        ({"effects.gravity": ["on", "off"]}, {}, "expected members with the same effects and formulation"),
        ({"wall_friction.coefficient": [0.1, -1]}, {}, "member 1 (wall_friction.coefficient=-1): "),
        ({"wall_fiction.coefficient": [0.1]}, {}, 'found "wall_fiction", did you mean "effects.wall_friction"?'),
        ({"wall_friction.coefficent": [0.1]}, {}, 'did you mean "coefficient"?'),
        ({"sticking": [0.5]}, {}, "did you mean effects.bit_torque_stribeck.sticking?"),
        ({"mud.density": [1000.0]}, {}, 'found "mud", did you mean effects.mud?'),
        ({"rigg.rotation.value": [1.0]}, {}, 'did you mean "rig"?'),
        (
            {"wob": [40, -12]},
            {},
            "wob: expected a weight on bit from 0, found -12; a bit that is pulled is given by rig.",
        ),
        ({"wob": ["-12 klb"]}, {}, "wob: expected a weight on bit from 0, found -12 klb"),
    ],
)
def test_bad_members_are_refused(vary, more, text):
    with pytest.raises((dt.ArgumentError, dt.SceneError), match=re.escape(text)):
        dt.Ensemble("pa6_bench", vary, overrides=COARSE, **more)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        (
            {"outputs": "colour"},
            "outputs: expected some of findings, extremes, contact, last_half, settling, marks, channels",
        ),
        ({"outputs": "energy"}, "outputs: expected numerics.audit: energy in the scene for `energy`, found none"),
        ({"duration": -1}, "duration: expected a time above 0 s, found -1 s"),
        ({"mark_rate": 1000}, "mark_rate: expected up to the frame rate of 100 Hz, found 1000 Hz"),
        ({"workers": 0}, "workers: expected a whole number of 1 or more, found 0"),
    ],
)
def test_bad_arguments_are_refused(more, text):
    with pytest.raises(dt.ArgumentError, match=re.escape(text)):
        dt.Ensemble("pa6_bench", {"wob": [40]}, overrides=COARSE).run(**more)


def test_stress_and_damage_of_members():
    sections = {"sections": [{"name": "middle", "distance_from_bit": 2.5}, {"name": "low", "measured_depth": 4.0}],
                "smallest_range": 1e4}  # fmt: skip
    stressed = {**COARSE, "effects.fatigue": sections, "effects.bit_friction": "off"}  # the kernel of test_fatigue.py
    found = dt.Ensemble("pa6_bench", {"wob": [20, 40]}, overrides=stressed).run(2.0, outputs="fatigue")
    assert found["damage"].shape == (2, 2)
    assert (found["largest_stress"] > 1e4).all()
    assert (found["stress_cycles"][1] > 0.0).all()
    assert (found["damage"][1] > found["damage"][0]).all()
    (failure,) = dt.Ensemble("pa6_bench", {"wob": [40]}, overrides=COARSE).run(0.1, outputs="fatigue").failed.values()
    assert "expected a scene with effects.fatigue" in failure


def test_members_that_run_end_when_no_more_are_wanted():
    """The second would go on for an hour."""
    scenes = {time: dt.load_scene("pa6_bench", COARSE | {"duration": time}) for time in (1, 3600)}
    reached = []

    def follow(scene, goes_on):
        twin = Twin(scene)
        for frames in frames_of(twin, *planned(scene), 10):
            assert frames.u.shape == (10, twin.elements + 1, 7)
            reached.append(twin.time)
            goes_on(twin.time)
        return twin.time

    members = member_run.on_threads(follow, scenes, 2)
    assert next(members) == (1, pytest.approx(1.0))
    members.close()
    assert 1.0 <= max(reached) < 3600.0
