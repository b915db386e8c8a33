# SPDX-License-Identifier: Apache-2.0
"""The well of the tests of torque and drag."""

import pytest
from bent_well import well

from drill_twin.scene import Scene


@pytest.fixture(scope="session")
def bent_well() -> Scene:
    """A well of 1,000 m with a bend."""
    return well()
