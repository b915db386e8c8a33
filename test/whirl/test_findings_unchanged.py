# SPDX-License-Identifier: Apache-2.0
"""The findings after every sample are what they were, bit for bit, and a block of samples gives them too."""

import json

import numpy as np
import pytest
from findings_hashes import FILE, bits, cases, environment, hash_of

from drill_twin.whirl import AnalysisError, Analyzer
from drill_twin.whirl.analyzer_kernel import compiled

KNOWN = json.loads(FILE.read_text("utf-8"))


@pytest.mark.parametrize("name", sorted(KNOWN["hashes"]))
def test_findings_are_what_they_were(name):
    if KNOWN["environment"] != environment():
        pytest.skip(f"the hashes are of {KNOWN['environment']}, the last bits of {environment()} may differ")
    marks, samples = cases()[name]
    assert hash_of(marks, samples()) == KNOWN["hashes"][name]


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


def test_a_step_called_from_python_is_refused():
    analyse = Analyzer(cases()["one mark"][0])._analyse.__self__
    with pytest.raises(TypeError, match="called by address only"):
        compiled().analyse(*analyse.arguments)
