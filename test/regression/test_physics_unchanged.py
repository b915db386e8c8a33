# SPDX-License-Identifier: Apache-2.0
"""Runs of the shipped scenes publish what they published before, bit for bit, and so do runs taken up half-way."""

import json

import pytest
from physics_hashes import FILE, cases, differences, environment

KNOWN = json.loads(FILE.read_text("utf-8"))


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(KNOWN["topics"]))
def test_a_run_publishes_what_it_published_before(name: str) -> None:
    if KNOWN["environment"] != environment():
        pytest.skip(f"the hashes are of {KNOWN['environment']}, the last bits of {environment()} may differ")
    scene = cases().get(name)
    if scene is None:
        pytest.skip("the record that the scene plays is not at hand")
    assert not differences(name, scene, KNOWN["topics"][name])
