# SPDX-License-Identifier: Apache-2.0
"""Bands of a fit hold as often as is printed; 300 twins: `make fit-coverage`."""

import re
from pathlib import Path

from scipy import stats

from drill_twin_evidence.foreign_rigs.interval_coverage import WAYS, cover
from drill_twin_studies.estimation.estimate import HELD as ESTIMATED
from drill_twin_studies.fitting.posterior import HELD as FITTED

DOCS = Path(__file__).parents[2] / "docs"


def counts(page, pattern):
    """Numbers of 300 that held, of the rows of a page of the evidence that match."""
    return [int(found[1]) for found in re.finditer(pattern, (DOCS / page).read_text("utf-8"), re.MULTILINE)]


def test_bands_hold_at_the_printed_rate():
    held = [one for seed in (8101, 8102) for way in cover(seed)["inside"].values() for one in way.values()]
    assert len(held) == 2 * 4 * len(WAYS)
    assert stats.binom.cdf(sum(held), len(held), 255 / 300) > 1e-3


def test_printed_counts_are_those_of_the_evidence():
    found = counts("fit.md", r"^\| (?:surface|with a sub) \| \S+ \| (\d+) of 300 ")
    assert len(found) == 8
    assert f"held {min(found)} (decay of friction) to {max(found)} (load)" in FITTED
    found = counts("estimator.md", r"^\| \S+ \| \S+% \| \d+ of 300 .*? \| (\d+) of 300 ")
    assert len(found) == 8
    assert f"in {min(found)} of 300 (wall friction with a sub) to {max(found)} of 300" in ESTIMATED
