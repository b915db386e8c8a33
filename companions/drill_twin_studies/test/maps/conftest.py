# SPDX-License-Identifier: Apache-2.0
"""A map of a coarse bench string, made once."""

import pytest
from coarse_map import ASKED, COARSE

import drill_twin as dt


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    """Folder of the map's journal."""
    return tmp_path_factory.mktemp("map")


@pytest.fixture(scope="session")
def found(place):
    """The map."""
    return dt.operating_map("pa6_bench", COARSE, folder=place, workers=2, **ASKED)
