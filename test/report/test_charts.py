# SPDX-License-Identifier: Apache-2.0
"""Charts have the values of the figures, in little room."""

import base64
import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from drill_twin.report import draw
from drill_twin.report.charts import CHARTS, chart
from drill_twin.report.recording import read_recording


def numbers(packed):
    if isinstance(packed, list):
        return packed[0] + packed[1] * np.arange(packed[2])
    return np.frombuffer(base64.b64decode(packed), "<f4")


@pytest.fixture(scope="module")
def recording(known_bag):
    return read_recording(known_bag)


def traces(found, panel, kind):
    return [trace for trace in found["panels"][panel]["traces"] if trace["kind"] == kind]


@pytest.mark.parametrize("name", CHARTS)
def test_every_chart_is_plain_json_with_labels_and_values(recording, name):
    found = chart(draw(name, recording))
    json.dumps(found, allow_nan=False)
    assert found["title"]
    for panel in found["panels"]:
        assert panel["traces"]
        assert np.isfinite(panel["x"]["range"] + panel["y"]["range"]).all()
        assert "names" not in panel["y"] or panel["y"]["names"][0] == "string"


def test_lines_have_the_values_of_the_run_and_the_onset_is_named(recording):
    found = chart(draw("displacement", recording))
    time, centre = recording.marks.time, 1e3 * recording.centre_lines()
    assert found["panels"][2]["title"].startswith("mark_3, mark_4, 0.5 m from the bit")  # both on one centre line
    for mark in range(3):
        x, y = (next(t for t in traces(found, mark, "line") if t["name"] == name) for name in ("x", "y"))
        assert numbers(x["x"]) == pytest.approx(time, abs=1e-4)
        assert numbers(x["y"]) == pytest.approx(centre[:, mark].real, abs=1e-3)
        assert numbers(y["y"]) == pytest.approx(centre[:, mark].imag, abs=1e-3)
        onset = [t for t in traces(found, mark, "across") if t["upright"]]
        assert [t["name"] for t in onset] == [f"onset {recording.summary.onset.time_s:.2f} s"]


def test_states_and_spectra_are_there(recording):
    states = traces(chart(draw("motion", recording)), 0, "area")
    assert {t["text"].partition(",")[0] for t in states} >= {"backward whirl"}
    (mesh,) = traces(chart(draw("spectrum_over_time", recording)), 0, "mesh")
    shape = (len(numbers(mesh["y"])) - 1, len(numbers(mesh["x"])) - 1)
    values = np.frombuffer(base64.b64decode(mesh["values"]), "u1").reshape(shape)
    assert mesh["columns"] == shape[1]
    frequency = numbers(mesh["y"])
    middle = 0.5 * (frequency[1:] + frequency[:-1])
    assert middle[values[:, -1].argmax()] == pytest.approx(-0.6, abs=0.3)
    spectrum = chart(draw("spectrum", recording))["panels"][0]
    assert spectrum["y"]["log"]
    assert {t["name"] for t in spectrum["traces"]} >= {"rotation 2.00 Hz", "whirl -0.60 Hz", "mark_1"}


def test_long_lines_keep_their_peaks():
    figure = Figure()
    time = np.linspace(0.0, 1.0, 100_001)
    values = np.sin(40.0 * time)
    values[54_321] = 7.0
    values[77] = np.nan
    figure.add_subplot().plot(time, values)
    (line,) = traces(chart(figure), 0, "line")
    assert len(numbers(line["y"])) <= 4100
    assert np.nanmax(numbers(line["y"])) == 7.0
    assert numbers(line["x"])[np.nanargmax(numbers(line["y"]))] == pytest.approx(0.54321, abs=1e-6)
    assert (np.diff(numbers(line["x"])) >= 0.0).all()


def test_displacement_of_a_mark_in_a_wider_hole_is_not_cut(recording, monkeypatch):
    """One scale for all marks holds the largest motion, not the smallest clearance."""
    places = tuple(replace(place, clearance=0.01) if k == 3 else place for k, place in enumerate(recording.places))
    monkeypatch.setattr(type(recording.scene), "mark_table", places)
    for panel in draw("displacement", recording).axes:
        assert panel.get_ylim()[1] >= 31.0
