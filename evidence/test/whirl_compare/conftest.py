# SPDX-License-Identifier: Apache-2.0
"""The bench in the lateral form."""

import pytest

from drill_twin.api import load_scene


@pytest.fixture(scope="session")
def bench():
    return load_scene("pa6_bench", {"effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "12"})
