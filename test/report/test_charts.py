# SPDX-License-Identifier: Apache-2.0
"""Charts have the values of the figures, in little room."""

import base64
import json
import math
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest
from matplotlib.figure import Figure

from drill_twin.report import draw
from drill_twin.report.charts import CHARTS, chart
from drill_twin.report.recording import read_recording


def numbers(packed):
    assert packed["dtype"] == "f4"
    return np.frombuffer(base64.b64decode(packed["bdata"]), "<f4")


def times(trace):
    """Horizontal place of each value, which may be given by the first and a step."""
    values = numbers(trace["y"])
    return numbers(trace["x"]) if "x" in trace else trace["x0"] + trace["dx"] * np.arange(values.size)


@pytest.fixture(scope="module")
def recording(known_bag):
    return read_recording(known_bag)


def traces(found, panel):
    return found["panels"][panel]["traces"]


def darkness(mesh):
    """Values and greys, 0 to 255, of the colours of a mesh."""
    at, greys = zip(*mesh["colorscale"], strict=True)
    span = mesh["zmax"] - mesh["zmin"]
    return mesh["zmin"] + span * np.array(at), [int(grey[4:].partition(",")[0]) for grey in greys]


@pytest.mark.parametrize("name", CHARTS)
def test_every_chart_is_plain_json_with_labels_and_values(recording, name):
    found = chart(draw(name, recording))
    json.dumps(found, allow_nan=False)
    assert found["title"]
    for panel in found["panels"]:
        assert panel["traces"]
        figure = go.Figure(panel["traces"], panel["layout"])  # raises where plotly does not know a key or a value
        assert np.isfinite(figure.layout.xaxis.range + figure.layout.yaxis.range).all()
        assert figure.layout.yaxis.ticktext in {None, ("string", *(f"mark_{k}" for k in range(1, 5)))}


def test_lines_have_the_values_of_the_run_and_the_onset_is_named(recording):
    found = chart(draw("displacement", recording))
    time, centre = recording.marks.time, 1e3 * recording.centre_lines()
    assert found["panels"][2]["title"].startswith("mark_3, mark_4, 0.5 m from the bit")  # both on one centre line
    for mark in range(3):
        x, y = (next(t for t in traces(found, mark) if t["name"] == name) for name in ("x", "y"))
        assert times(x) == pytest.approx(time, abs=1e-4)
        assert numbers(x["y"]) == pytest.approx(centre[:, mark].real, abs=1e-3)
        assert numbers(y["y"]) == pytest.approx(centre[:, mark].imag, abs=1e-3)
        onset = [one for one in found["panels"][mark]["layout"]["shapes"] if one["x0"] == one["x1"]]
        assert [one["label"]["text"] for one in onset] == [f"onset {recording.summary.onset.time_s:.2f} s"]


def test_states_and_spectra_are_there(recording):
    states = [trace for trace in traces(chart(draw("motion", recording)), 0) if trace.get("text")]
    assert {t["text"].partition(",")[0] for t in states} >= {"backward whirl"}
    named = [t["name"] for t in states if t["showlegend"]]
    assert sorted(named) == sorted({t["name"] for t in states})  # each once
    (mesh,) = (one for one in traces(chart(draw("spectrum_over_time", recording)), 0) if one["type"] == "heatmap")
    shape = (len(numbers(mesh["y"])) - 1, len(numbers(mesh["x"])) - 1)
    values = numbers(mesh["z"]).reshape(shape)
    assert mesh["z"]["shape"] == f"{shape[0]}, {shape[1]}"
    assert [mesh["zmin"], mesh["zmax"]] == pytest.approx([values.min(), values.max()])
    assert [mesh["colorscale"][k][0] for k in (0, -1)] == [0.0, 1.0]  # else plotly.js takes other colours
    middle_grey = np.interp(math.sqrt(mesh["zmin"] * mesh["zmax"]), *darkness(mesh))
    assert middle_grey == pytest.approx(127.5, abs=1.0)  # half way on the scale of logarithms
    frequency = numbers(mesh["y"])
    middle = 0.5 * (frequency[1:] + frequency[:-1])
    assert middle[values[:, -1].argmax()] == pytest.approx(-0.6, abs=0.3)
    spectrum = chart(draw("spectrum", recording))["panels"][0]
    assert spectrum["layout"]["yaxis"]["type"] == "log"
    named = {t["name"] for t in spectrum["traces"]} | {one["label"]["text"] for one in spectrum["layout"]["shapes"]}
    assert named >= {"rotation 2.00 Hz", "whirl -0.60 Hz", "mark_1"}


def test_long_lines_keep_their_peaks():
    figure = Figure()
    time = np.linspace(0.0, 1.0, 100_001)
    values = np.sin(40.0 * time)
    values[54_321] = 7.0
    values[77] = np.nan
    figure.add_subplot().plot(time, values)
    (line,) = traces(chart(figure), 0)
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
