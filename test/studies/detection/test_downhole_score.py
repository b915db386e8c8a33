# SPDX-License-Identifier: Apache-2.0
"""Score of whirl found from one sub."""

import pytest

from drill_twin.studies.detection.downhole import markdown, measure_sub


@pytest.mark.long
def test_a_sub_is_scored():
    found = measure_sub(2, 0.05)
    assert (len(found.onset_error) + found.missed, found.false, found.noise_onsets) == (1, 0, 0)
    assert abs(found.onset_error[0]) < 2.0
    assert found.senses == [True]
    assert "| missed, false | 0, 0 |" in markdown(found.to_dict(), 2, 0.05)
