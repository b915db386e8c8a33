# SPDX-License-Identifier: Apache-2.0
"""Score of whirl, impacts and stick-slip found from one sub."""

import pytest

from drill_twin_evidence.detection.downhole import markdown, measure_sub
from drill_twin_evidence.detection.sub_onsets import main, motion, shares


@pytest.mark.long
def test_a_sub_is_scored():
    found = measure_sub(2, 0, 1, 0.02)
    bench, events = found["sets"]["bench"], found["events"]
    assert (bench["onsets"], bench["missed"], bench["false"], found["noise_onsets"]) == (1, 0, 0, 0)
    assert (bench["met"], bench["sense"]) == (1.0, 1.0)
    assert events["hard_impacts_found"] > 0.9
    assert events["impacts_in_contact"] > 0.6
    assert events["stick_slip_found"] == events["stick_slip_runs"] == 1
    assert events["largest_error"]["period"] < 0.05
    assert events["largest_error"]["severity"] < 0.2
    assert events["largest_error"]["rest"] < 0.02
    assert "| missed, of these slower than the corner | 0, 0 | 0, 0 |" in markdown(found)


def test_the_share_of_onsets_within_their_uncertainty_is_counted_and_goes_on(tmp_path, capsys):
    row = motion(6001)
    assert row["true"] is not None
    rows = [{**row, "found": row["true"] + off, "uncertainty": 1.0, "dated": False} for off in (0.5, -0.5, 2.0, 0.0)]
    assert "75.0% of 4 hold the true one; 95 % interval of the share 19.4% to 99.4%" in shares(rows)[1]
    main(0, tmp_path / "rows.jsonl")
    assert capsys.readouterr().out == "\n"
