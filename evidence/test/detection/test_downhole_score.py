# SPDX-License-Identifier: Apache-2.0
"""Score of whirl, impacts and stick-slip found from one sub."""

import pytest

from drill_twin_evidence.detection.downhole import markdown, measure_sub


@pytest.mark.long
def test_a_sub_is_scored():
    found = measure_sub(2, 0, 1, 0.02)
    bench, events = found["sets"]["bench"], found["events"]
    assert (bench["onsets"], bench["missed"], bench["false"], found["noise_onsets"]) == (1, 0, 0, 0)
    assert (bench["met"], bench["dated_met"], bench["sense"]) == (1.0, 1.0, 1.0)
    assert events["hard_impacts_found"] > 0.9
    assert events["impacts_in_contact"] > 0.6
    assert events["stick_slip_found"] == events["stick_slip_runs"] == 1
    assert events["largest_error"]["period"] < 0.05
    assert events["largest_error"]["severity"] < 0.2
    assert events["largest_error"]["rest"] < 0.02
    assert "| missed, of these slower than the corner | 0, 0 | 0, 0 |" in markdown(found)
