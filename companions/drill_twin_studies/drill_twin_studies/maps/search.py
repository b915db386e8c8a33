# SPDX-License-Identifier: Apache-2.0
"""Search for the boundaries of a map: onset of whirl first, then other regimes, draws, and the end of a whirl.

Each step depends on the labels of the runs before alone, never on their order or time. So a search that was broken off
takes the runs of its journal and ends with the same map.

Growth rates of the linear string place the first runs. A whirl that grows slowly begins after the end of a run, and
friction starts whirls that no growth rate knows: so the growth rate at which whirl begins is not taken to be zero, but
found from the runs so far.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError
from drill_twin.core.files.json_files import JsonLines
from drill_twin.dynamics.rotordynamics.campbell import GrowthMap, growth_map
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.scene import Scene
from drill_twin_studies.maps.plane import (
    UNKNOWN,
    Labels,
    Node,
    Plane,
    differ,
    filled,
    nearest_known,
    on_lattice,
    wanted,
)
from drill_twin_studies.maps.regimes import Regime
from drill_twin_studies.maps.runs import HOLD, Key, Runner, RunRecord

GROWTH_POINTS = 33
"""Points of the map of growth rates along each range."""


def growth_of(scene: Scene, plane: Plane) -> GrowthMap | None:
    """Largest growth rates over the plane; None where the string has no such map."""
    weights, speeds = (np.linspace(span.low, span.high, GROWTH_POINTS) for span in (plane.weight, plane.speed))
    try:
        return growth_map(EquationsOfMotion(scene), weights, speeds)
    except DrillTwinError:  # a hole that is not vertical, an effect that depends on time, no balance
        return None


def expected(growth: Array, labels: Labels) -> Labels | None:
    """Labels that the growth rates let expect: whirl above the rate that parts the known labels with the fewest errors.

    Args:
        growth: Growth rates on an even grid [1/s].
        labels: What is known of whirl; with one label only the rate is zero.

    Returns:
        Expected label of each node; None where the growth rates explain less than half of the rarer label.
    """
    values, known = on_lattice(growth, labels.shape[0] - 1), labels != UNKNOWN
    order = np.argsort(values[known], kind="stable")
    rates, whirls = values[known][order], labels[known][order] == 1
    rarer = min(whirls.sum(), (~whirls).sum())
    if rarer == 0:
        return np.asarray(values > 0.0, np.int8)
    below, above = np.cumsum(whirls)[:-1], np.cumsum(~whirls[::-1])[-2::-1]
    errors = np.where(np.diff(rates) > 0.0, below + above, whirls.size)
    place = int(np.argmin(errors, axis=0)) if errors.size else 0
    if not errors.size or 2 * errors[place] >= rarer:
        return None
    return np.asarray(values > 0.5 * (rates[place] + rates[place + 1]), np.int8)


Journal = JsonLines[tuple[Key, RunRecord]]
"""Runs of a map in the order in which they ended."""


def open_journal(folder: Path, setup: Mapping[str, Any]) -> Journal:
    """Open the file `runs.jsonl` of a folder, and read what it has.

    Args:
        folder: The folder; it need not exist.
        setup: Scene, ranges and all else that the runs depend on, in plain types.

    Raises:
        ArgumentError: The file is of another setup, or no journal.
        BagError: The file cannot be read or written.
    """
    remedy = "choose another folder with --out, or --replace"
    return JsonLines(folder / "runs.jsonl", tuple[Key, RunRecord], "map", setup, remedy=remedy)


ONSET_CELLS, COARSE = 8, 16
"""Cells along each range before any is split: in the search for the onset, and in all others."""
FEW_RUNS, FEW_CELLS = 200, 4
"""Number of runs up to which a map begins with fewer cells, so that some are left for the other boundaries."""
REGIME_CELLS = 32
"""Cells along each range down to which boundaries between other regimes are followed, and where draws are made."""
FEW = 3
"""Draws after the first that are made along the onset; if none of them whirls, all others follow; not measured."""
EARLY = 0.8
"""Share of the duration within which a whirl must begin for another run to come from it; not measured."""

Progress = Callable[[str, int, int], None]
"""Takes the phase, the runs that have ended, and the number expected by now."""


def whirl_label(record: RunRecord) -> int:
    """Label of a run in the search for the onset: 0 without whirl, 1 with whirl, 2 not known, for it failed."""
    return 2 if record.regime is Regime.FAILED else int(record.whirls)


class BoundarySearch:
    """Search of one map.

    Attributes:
        records: Runs that the search took, in its order.
        notes: What limits the map, as sentences.
    """

    def __init__(
        self, runner: Runner, journal: Journal | None, budget: int, progress: Progress, growth: Array | None
    ) -> None:
        """Begin.

        Args:
            runner: Makes the runs.
            journal: Keeps the runs; None: no run is kept.
            budget: Largest number of runs.
            progress: Takes phase, runs that have ended, and the number expected by now.
            growth: Growth rates at the points of an even grid [1/s]; None where they do not apply.
        """
        self._runner, self._journal, self._budget, self._progress = runner, journal, budget, progress
        self.records: dict[Key, RunRecord] = {}
        self.notes: list[str] = []
        self._growth, self._plane, self._steps = growth, runner.plane, runner.plane.steps
        self._first, self._others = (FEW_CELLS, FEW_CELLS) if budget <= FEW_RUNS else (ONSET_CELLS, COARSE)
        if growth is not None:
            self._first = FEW_CELLS

    # --- phases ---------------------------------------------------------------------------------------------------

    def calm(self) -> None:
        """Find the calm set-points, to a 32nd of the ranges: the windows need them first."""
        finest = max(1, self._steps // REGIME_CELLS)
        self._refine("calm", lambda record: int(record.calm), FEW_CELLS, finest)

    def onset(self) -> None:
        """Find the set-points at which whirl begins from rest, to one step of the lattice."""
        self._refine("onset of whirl", whirl_label, self._first, 1, self._growth)

    def regimes(self) -> None:
        """Find the boundaries between all regimes."""
        self._refine("regimes", lambda record: record.regime.code, self._others, max(1, self._steps // REGIME_CELLS))

    def draws(self) -> None:
        """Repeat the runs along the onset with other seeds and numbers: a few at each node, all where none whirls.

        If one of a few draws whirls, the chance is above what is asked, however many more draws would be made.
        """
        count, size = len(self._runner.draws), max(1, self._steps // REGIME_CELLS)
        labels = self._labels(whirl_label)
        for numbers in (range(1, min(FEW + 1, count)), range(FEW + 1, count)):
            while True:
                nodes = [node for node in self._beside(labels, size) if not self._draw_whirls(node)]
                made = self.make("draws", [Key(*node, draw) for node in nodes for draw in numbers])
                for node in nodes:  # a node that whirls in some draws is a boundary too
                    labels[node] = 1 if self._draw_whirls(node) else labels[node]
                if not made:
                    break
                if numbers.start == 1 and self._nothing_changes():
                    self.notes.append("seeds and varied numbers change no run of this scene: one draw is enough")
                    return

    def end_of_whirl(self) -> None:
        """Find the set-points at which a whirl dies, by runs from a whirling set-point to set-points calm from rest."""
        whirling = self._plane.labels()
        for key, record in self._from_rest():
            early = record.onset_s < EARLY * self._runner.duration
            whirling[key.node] = 1 if record.whirls and early else UNKNOWN
        if not (whirling == 1).any():
            self.notes.append("no whirl was found that could die")
            return
        origins = nearest_known(whirling == 1)
        size = max(1, self._steps // (4 * self._others))
        labels = np.where(filled(self._labels(whirl_label)) == 1, 1, UNKNOWN).astype(np.int8)
        while nodes := wanted(labels, max(1, self._steps // self._others), size):
            keys = [Key(*node, 0, (int(origins[0][node]), int(origins[1][node]))) for node in nodes]
            if not self.make("end of whirl", keys):
                break
            for key in keys:
                if key in self.records:
                    labels[key.node] = self.records[key].whirls
        hold = HOLD * self._runner.duration
        unmade = [key for key, record in self.records.items() if key.origin and not record.onset_s < hold]
        if unmade:
            self.notes.append(f"in {len(unmade)} runs from a whirl it had not begun when the set-points moved")

    # --- steps ----------------------------------------------------------------------------------------------------

    def _from_rest(self) -> Iterable[tuple[Key, RunRecord]]:
        return [(key, record) for key, record in self.records.items() if key.searches and key.draw == 0]

    def _labels(self, label: Callable[[RunRecord], int]) -> Labels:
        labels = self._plane.labels()
        for key, record in self._from_rest():
            labels[key.node] = label(record)
        return labels

    def _refine(
        self, phase: str, label: Callable[[RunRecord], int], cells: int, finest: int, growth: Array | None = None
    ) -> None:
        coarse, hinted = max(1, self._steps // cells), max(finest, self._steps // REGIME_CELLS)
        while True:
            labels = self._labels(label)
            hint = None if growth is None else expected(growth, labels)
            nodes = wanted(labels, coarse, finest, hint, hinted)
            if not nodes or not self.make(phase, [Key(*node) for node in nodes]):
                return

    def _beside(self, labels: Labels, size: int) -> list[Node]:
        """Corners of the cells of a size in which labels differ, if they have a run."""
        found: dict[Node, None] = {}
        for i in range(0, self._steps, size):
            for j in range(0, self._steps, size):
                if differ(labels[i : i + size + 1, j : j + size + 1]):
                    found.update(dict.fromkeys((a, b) for a in (i, i + size) for b in (j, j + size)))
        return [node for node in found if Key(*node) in self.records]

    def _draw_whirls(self, node: Node) -> bool:
        """A draw at a node whirls."""
        made = (self.records.get(Key(*node, draw)) for draw in range(max(1, len(self._runner.draws))))
        return any(record is not None and record.whirls for record in made)

    def _nothing_changes(self) -> bool:
        drawn = [key for key in self.records if key.draw]
        return bool(drawn) and all(self.records[key] == self.records[Key(key.i, key.j)] for key in drawn)

    def make(self, phase: str, keys: Sequence[Key], *, beyond: bool = False) -> bool:
        """Make runs, or take them from the journal; False where none is new, or no more may be made.

        Args:
            phase: Phase of the search.
            keys: The runs.
            beyond: True if the runs do not count against the largest number of runs.
        """
        new = [key for key in dict.fromkeys(keys) if key not in self.records]
        room = len(new) if beyond else self._budget - len(self.records)
        if len(new) > room:
            note = f"stopped at {self._budget} runs in the search for the {phase}; more with --runs"
            self.notes.extend([note] if note not in self.notes else [])
        new = new[:room]
        known = {} if self._journal is None else dict(self._journal.results)
        missing = [key for key in new if key not in known]
        made = dict[Key, RunRecord]()
        before, expected = len(self.records) + len(new) - len(missing), len(self.records) + len(new)
        with closing(self._runner.run(missing)) as ended:
            for key, record in ended:
                if self._journal is not None:
                    self._journal.add((key, record))
                made[key] = record
                self._progress(phase, before + len(made), expected)
        self.records |= {key: made[key] if key in made else known[key] for key in new}
        return bool(new)
