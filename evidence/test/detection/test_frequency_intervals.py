# SPDX-License-Identifier: Apache-2.0
"""Intervals of whirl frequencies hold at the promised rate; `detection.frequency` is a command that counts more."""

import pytest
from scipy import stats

from drill_twin_evidence.detection.frequency import analysed, counts, holds

FIRST, COUNT = 20_000, 40
"""Seeds by which nothing was chosen."""


@pytest.mark.parametrize("kind", ["constant", "modulated", "wandering", "alternating"])
def test_nine_of_ten_intervals_hold(kind):
    found = [analysed(kind, FIRST + number) for number in range(COUNT)]
    settled = [one for one in found if one.summary.whirl_frequency_hz and one.summary.whirl_frequency_changes is False]
    assert len(settled) > 0.5 * COUNT
    assert stats.binom.cdf(sum(map(holds, settled)), len(settled), 0.9) > 1e-3
    for one in found:
        if one.summary.whirl_frequency_hz is not None:
            low, high = one.summary.whirl_frequency_interval_hz
            assert low <= one.summary.whirl_frequency_hz <= high
    assert counts(kind, found)[0] == kind


def test_drifting_whirls_are_not_called_settled():
    found = [analysed("drifting", FIRST + number) for number in range(COUNT)]
    assert sum(one.summary.whirl_frequency_changes is False for one in found) <= 3
