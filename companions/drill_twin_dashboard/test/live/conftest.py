# SPDX-License-Identifier: Apache-2.0
"""Servers of the page, for tests."""

import time

import pytest
from served_page import Served


@pytest.fixture
def serve():
    served = []

    def make(*given, **options):
        served.append(Served(*given, **options))
        return served[-1]

    yield make
    for one in served:
        begun = time.monotonic()
        one.server.close()
        assert time.monotonic() - begun < 4.0
