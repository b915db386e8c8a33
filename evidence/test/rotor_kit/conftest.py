# SPDX-License-Identifier: Apache-2.0
"""Public data of the rotor kit and the hanging rod, which lie beside the repository and are never part of it."""

from pathlib import Path

import pytest

SHARED = Path(__file__).parents[4] / "shared/data"
PREDICTIONS = Path(__file__).parents[2] / "predictions"


@pytest.fixture(scope="session")
def kit_file():
    """The record of the rotor kit at 1,005 rpm."""
    path = SHARED / "rk4/records_1005rpm.csv"
    if not path.exists():
        pytest.skip(f"the public record of the rotor kit is not at {path}")
    return path


@pytest.fixture(scope="session")
def rod_folder():
    """The spectra of the hanging rod."""
    path = SHARED / "hanging_rod"
    if not path.exists():
        pytest.skip(f"the public spectra of the hanging rod are not at {path}")
    return path


@pytest.fixture(scope="session")
def predictions():
    """The folder of committed predictions."""
    return PREDICTIONS
