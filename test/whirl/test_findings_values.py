# SPDX-License-Identifier: Apache-2.0
"""Findings of labelled motions are what they were, and a block of samples gives the bits that its samples give."""

import json

import numpy as np
import pytest
from findings_values import FILE, bits, cases, difference, values

from drill_twin.whirl import AnalysisError, Analyzer

KNOWN = json.loads(FILE.read_text("utf-8"))


@pytest.mark.parametrize("name", sorted(KNOWN))
def test_findings_are_what_they_were(name):
    marks, samples = cases()[name]
    assert difference(KNOWN[name], values(marks, samples())) == ""


def test_round_off_of_the_samples_moves_findings_by_no_more():
    """The first bins are those of the run-out exactly: what is left of them has no direction that may count."""
    marks, samples = cases()["forward"]
    random = np.random.default_rng(1)
    moved = ((stamp, at * (1.0 + 1e-15 * random.normal(size=at.shape)), *rest) for stamp, at, *rest in samples())
    assert difference(KNOWN["forward"], values(marks, moved)) == ""


@pytest.mark.parametrize("name", ["passing", "without spin", "rolling, forces"])
def test_a_block_of_samples_is_as_its_samples(name):
    marks, samples = cases()[name]
    one, whole = Analyzer(marks), Analyzer(marks)
    columns = list(zip(*samples(), strict=True))
    for sample in zip(*columns, strict=True):
        one.push(*sample)
    arrays = [None if column[0] is None else np.array(column) for column in columns]
    for part in (slice(0, 700), slice(700, 701), slice(701, None)):
        whole.push_block(*(None if column is None else column[part] for column in arrays))
    assert bits(whole.findings) == bits(one.findings)
    assert repr(whole.summary()) == repr(one.summary())


def test_a_stamp_beyond_64_bits_is_refused():
    marks, samples = cases()["one mark"]
    _, *rest = next(samples())
    with pytest.raises(AnalysisError, match=r"at most \d+ ns"):
        Analyzer(marks).push(1 << 63, *rest)
