# SPDX-License-Identifier: Apache-2.0
"""Front doors, for tests."""

import pytest
from served_front import Front


@pytest.fixture
def front(tmp_path):
    folder = tmp_path / "wells of a rig"
    folder.mkdir()
    found = Front(folder)
    yield found
    found.server.close()
