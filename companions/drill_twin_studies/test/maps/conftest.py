# SPDX-License-Identifier: Apache-2.0
"""A map of a coarse bench string, made once, whichever worker asks for it first."""

import fcntl
import os

import pytest
from coarse_map import ASKED, COARSE

import drill_twin as dt


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    """Folder that is the same for all workers."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "operating_map"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def found(shared):
    """The map; a second worker finds its runs in the journal."""
    with shared.with_name("operating_map.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return dt.operating_map("pa6_bench", COARSE, folder=shared, workers=2, **ASKED)


@pytest.fixture(scope="session")
def place(found, shared):
    """Folder of the map's journal; for reading only."""
    return shared
