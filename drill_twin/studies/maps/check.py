# SPDX-License-Identifier: Apache-2.0
"""Checks of safe windows: runs of the whole time asked at set-points drawn in them, until all of a round are calm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drill_twin.studies.maps.operating_map import OperatingMap
from drill_twin.studies.maps.regimes import Regime
from drill_twin.studies.maps.runs import FINER, Key
from drill_twin.studies.maps.search import BoundarySearch
from drill_twin.studies.maps.window import cells_of

MOST, RUNS_FOR_ONE = 59, 20
"""Checks of a round: 59 of 59 show that at most 5 % are not calm (95 %); at most one for so many runs of a map."""
ROUNDS = 4


def check(search: BoundarySearch, made: Callable[[], OperatingMap], runs: int, draws: int) -> None:
    """Check the windows; each check that fails makes them smaller, and a new round begins.

    Args:
        search: Search whose runs the map has.
        made: Makes the map of its runs so far.
        runs: Largest number of runs of the search.
        draws: Number of draws, one after the other for the checks; 0 without.
    """
    count = min(MOST, runs // RUNS_FOR_ONE)
    for number in range(ROUNDS):
        cells = np.argwhere(cells_of(made()))
        if not (count and cells.size):
            return
        random = np.random.default_rng(number)
        places = cells[random.integers(len(cells), size=count)] * FINER + random.integers(FINER + 1, size=(count, 2))
        keys = [Key(i, j, k % max(1, draws), None, FINER) for k, (i, j) in enumerate(places.tolist())]
        search.make("check of the windows", keys, beyond=True)
        if all(search.records[key].regime is Regime.SMOOTH for key in keys):
            return
