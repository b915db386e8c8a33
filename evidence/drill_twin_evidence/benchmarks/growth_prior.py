# SPDX-License-Identifier: Apache-2.0
"""Runs that the search for an onset needs with and without growth rates.

    python -m drill_twin_evidence.benchmarks.growth_prior MAP ...

The search is repeated on `map.json` files: a run takes the regime of the map at its node. Printed are the runs of the
search, and the share of the lattice whose label it gets wrong.
"""

from __future__ import annotations

import argparse
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drill_twin.core.table import Table, markdown_row
from drill_twin.runs.ensemble import Threads
from drill_twin.scene import parse_scene
from drill_twin_studies.maps import read_map
from drill_twin_studies.maps.plane import Labels, filled
from drill_twin_studies.maps.regimes import REGIMES
from drill_twin_studies.maps.runs import Key, Runner, RunRecord
from drill_twin_studies.maps.search import BoundarySearch, growth_of


@dataclass(frozen=True)
class Replayed(Runner):
    """Runner that takes its runs from a map."""

    regimes: Labels

    def run(self, keys: Sequence[Key]) -> Generator[tuple[Key, RunRecord]]:
        """Regimes of the map."""
        yield from ((key, RunRecord(REGIMES[int(self.regimes[key.node])])) for key in keys)


def main() -> None:
    """Print a line a map."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("maps", nargs="+", type=Path)
    print(Table(("map", "steps", "runs without growth rates", "wrong", "with", "wrong"), ()).markdown())
    for file in parser.parse_args().maps:
        found = read_map(file)
        growth = growth_of(parse_scene(found.scene), found.plane)
        whirls = np.array([regime.whirls for regime in REGIMES])[found.regimes]
        runner = Replayed(
            parse_scene(found.scene), found.plane, found.duration, found.asked, (), Threads(), found.regimes
        )
        cells: list[object] = []
        for given in (None, None if growth is None else growth.lateral):
            search = BoundarySearch(runner, None, 10**6, lambda *_: None, given)
            search.onset()
            labels = found.plane.labels()
            for key, record in search.records.items():
                labels[key.node] = record.whirls
            cells += [len(search.records), f"{np.mean((filled(labels) == 1) != whirls):.1%}"]
        print(markdown_row([found.name, found.plane.steps, *cells]))


if __name__ == "__main__":
    main()
