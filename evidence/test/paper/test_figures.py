# SPDX-License-Identifier: Apache-2.0
"""Figures of the reproduction say what a reader needs: both frequencies of a motion, units."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from drill_twin_evidence.paper.pages import figures
from drill_twin_evidence.paper.runs.cases import LOAD, LOADS, SPEED, SPEEDS, Case


@pytest.fixture
def done() -> Any:
    cases = {Case(load, SPEED) for load in LOADS} | {Case(LOAD, speed) for speed in SPEEDS}
    measured = {
        case: SimpleNamespace(onset_s=1.0, frequency_hz=1.45, ratio=1.45 / case.speed, line_hz=0.22) for case in cases
    }
    return SimpleNamespace(measured=measured)


@pytest.mark.parametrize("name", ["over_load", "over_speed"])
def test_the_highest_line_stands_beside_the_whirl(done, name):
    """At 300 N they differ: 1.45 Hz and 0.22 Hz, which the figure of the spectra shows."""
    figure = getattr(figures, name)(done)
    for panel, turn in zip(figure.axes[1:], (1.0, 1.0 / SPEED), strict=True):
        lines = {line.get_label(): line.get_ydata() for line in panel.get_lines()}
        if name == "over_load":
            assert lines["ours, of the centre line"] == pytest.approx(1.45 * turn)
            assert lines["ours, highest line along x"] == pytest.approx(0.22 * turn)
        assert np.isfinite(lines["ours, highest line along x"]).all()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "ours, of the centre line", "ours, highest line along x", "published",
    ]  # fmt: skip


def test_orbits_of_the_full_size_assembly_have_units():
    run: Any = SimpleNamespace(centre=np.zeros((3, 1, 3)), time=np.arange(3.0), index=lambda _: 0)
    panel = figures._orbit(Figure(), (0.1, 0.1, 0.8, 0.8), run, "160 kN", 0.0)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x [mm]", "y [mm]")
