# SPDX-License-Identifier: Apache-2.0
"""Fields of an operating map over its lattice, and its calm windows: rectangles of set-points that stay calm.

The plane is judged in cells of one step. A cell stays calm if
* it lies in a cell of the search whose four corners have runs, all of them calm (`RunRecord.calm`: no whirl but
  creeping, settled, and of a severity that is at most low) in all their draws; the smallest such cell decides;
* the linear string does not grow at any of its corners, where its growth is known and the string on the axis;
* a whirl that exists dies or creeps in it, where the end of whirls was searched;
* no check in it failed: a run of the whole time asked;
* it keeps `MARGIN` to the next cell that does not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.units.system import SYSTEMS, UnitSystem
from drill_twin.scene.load import parse_scene
from drill_twin_studies.maps.plane import (
    UNKNOWN,
    Labels,
    Node,
    Plane,
    Span,
    boundary,
    corners,
    depth,
    filled,
    known_and_calm,
    nearest_known,
    on_lattice,
    rectangles,
)
from drill_twin_studies.maps.proportions import CONFIDENCE, proportion_interval
from drill_twin_studies.maps.regimes import OFF_AXIS, Regime
from drill_twin_studies.maps.runs import Key, RunRecord

LIKELY = 0.05
"""Largest upper limit (95 %) of the chance of whirl at a calm set-point, once there are draws enough to show it."""


MARGIN = 0.02
"""Distance that a window keeps to what is not calm, as a share of the ranges; not measured."""


class CalmWindow(NamedTuple):
    """Rectangle of set-points."""

    weight: Span
    """Weight on bit [N]."""
    speed: Span
    """Speed [rad/s]."""


@dataclass(frozen=True)
class MapFields:
    """Runs of a map, and what the runs show at each node and cell of the lattice.

    Attributes:
        name: Name of the scene.
        digest: `digest_of` the scene.
        scene: The scene, as YAML.
        plane: Lattice of the runs.
        duration: Simulated time of a run from rest [s].
        draws: Values of the uncertain numbers by key, one mapping a draw; empty without draws.
        records: The runs.
        notes: What limits the map, as sentences.
        growth: Largest growth of a lateral mode at the nodes of an even grid [1/s]; empty where it does not apply.
        torsional: Largest growth of a motion about or along the axis, likewise; empty in the lateral form.
        asked: Time for which a calm set-point must stay calm [s].
        clean_checks: Checks of the last round, if all of them were calm; 0 otherwise.
    """

    name: str
    digest: str
    scene: str
    plane: Plane
    duration: float
    draws: Sequence[Mapping[str, float | str]]
    records: Mapping[Key, RunRecord]
    notes: Sequence[str] = ()
    growth: Sequence[Sequence[float]] = field(default=())
    torsional: Sequence[Sequence[float]] = field(default=())
    asked: float = 0.0
    clean_checks: int = 0

    @cached_property
    def units(self) -> UnitSystem:
        """Units in which people read the map: its scene's."""
        return parse_scene(self.scene).unit_system if self.scene else SYSTEMS["lab"]

    @cached_property
    def regimes(self) -> Labels:
        """Code of the regime at each node, from the nearest run at the first draw."""
        labels = self.plane.labels()
        for node, runs in self.runs_at_nodes.items():
            labels[node] = runs[0].regime.code
        return filled(labels)

    @cached_property
    def runs_at_nodes(self) -> Mapping[Node, Sequence[RunRecord]]:
        """Runs from rest at each node that has them, the first draw first."""
        runs: dict[Node, list[RunRecord]] = {}
        for key in sorted((key for key in self.records if key.searches), key=lambda key: key.draw):
            runs.setdefault(key.node, []).append(self.records[key])
        return runs

    @cached_property
    def whirls(self) -> Mask:
        """Nodes at which the string whirls from rest, or may in some draws.

        With draws, the upper limit of the chance must be as low as `LIKELY`, or as low as so many draws can show. Runs
        that failed say nothing of whirl.
        """
        labels = self.plane.labels()
        for node, runs in self.runs_at_nodes.items():
            followed = [record for record in runs if record.regime is not Regime.FAILED]
            count = sum(record.whirls for record in followed)
            if followed:
                most, least = (proportion_interval(k, len(followed), CONFIDENCE)[1] for k in (count, 0))
                labels[node] = most > max(LIKELY, least)
        return np.asarray(filled(labels) == 1) if (labels != UNKNOWN).any() else labels == 1

    @cached_property
    def known(self) -> Mask:
        """Unit cells between runs of the search, shape (n, n); elsewhere the map shows the nearest run alone."""
        made = self._calm_runs != UNKNOWN
        return known_and_calm(made, made)[0]

    @cached_property
    def _calm_runs(self) -> Labels:
        """1 for nodes whose runs are all calm, in all their draws; 0 for other nodes with runs."""
        labels = self.plane.labels()
        for node, runs in self.runs_at_nodes.items():
            labels[node] = all(record.calm for record in runs)
        return labels

    @cached_property
    def severities(self) -> Labels:
        """Grade of severity at each node, from the nearest run at the first draw; `UNKNOWN` where the run failed."""
        places = nearest_known(self._calm_runs != UNKNOWN)
        runs = (self.runs_at_nodes[node][0].severity for node in zip(*places.reshape(2, -1).tolist(), strict=True))
        return np.array([UNKNOWN if grade is None else grade for grade in runs], np.int8).reshape(places.shape[1:])

    @cached_property
    def largest_growth(self) -> Array:
        """Largest growth of the straight string at each node [1/s]; where it has left the axis of no lateral motion,
        and -inf where none is known.
        """
        lateral, torsional = (
            on_lattice(np.array(grid), self.plane.steps) if len(grid) else np.full(self.regimes.shape, -np.inf)
            for grid in (self.growth, self.torsional)
        )
        off = np.isin(self.regimes, [regime.code for regime in OFF_AXIS])
        return np.asarray(np.maximum(np.where(off, -np.inf, lateral), torsional))

    @cached_property
    def keeps_whirling(self) -> Mask:
        """Nodes at which an existing whirl does not die; nodes at which whirl begins from rest are among them."""
        falling = {key.node: record.whirls for key, record in self.records.items() if key.origin is not None}
        if not falling:
            return self.whirls
        labels = self.plane.labels()
        labels[self.whirls] = 1
        for node, whirls in falling.items():
            labels[node] = max(int(labels[node]), int(whirls))
        return np.asarray(self.whirls | (filled(labels) == 1))

    @cached_property
    def calm(self) -> Mask:
        """Nodes that are calm from rest in all draws, at which the straight string does not grow."""
        return np.asarray((filled(self._calm_runs) == 1) & ~self.whirls & (self.largest_growth <= 0.0))

    @property
    def has_second_boundary(self) -> bool:
        """The map has runs in which a whirl may die."""
        return any(key.origin is not None for key in self.records)

    @property
    def checks(self) -> Sequence[tuple[Key, RunRecord]]:
        """Runs of the whole time asked at set-points drawn in the windows."""
        return [(key, record) for key, record in self.records.items() if key.finer > 1]

    def lines(self, flags: Mask) -> list[list[list[float]]]:
        """Boundary of flagged nodes: segments of two points, weight on bit [N] and speed [rad/s]."""
        return [[list(self.plane.command((float(x), float(y)))) for x, y in ends] for ends in boundary(flags)]

    @property
    def calm_cells(self) -> Mask:
        """Unit cells that stay calm, shape (n, n)."""
        good = known_and_calm(self._calm_runs != UNKNOWN, self._calm_runs == 1)[1]
        good &= corners(self.largest_growth).max(axis=0) <= 0.0
        if self.has_second_boundary:
            good &= ~corners(self.keeps_whirling).any(axis=0)
        for key, record in self.checks:
            if not record.calm:
                good[self.plane.cells_at(key.place)] = False
        return np.asarray(depth(good) > MARGIN * self.plane.steps + 0.5)

    @cached_property
    def window_nodes(self) -> Sequence[tuple[int, int, int, int]]:
        """First and last node of each window along weight on bit and speed."""
        return rectangles(self.calm_cells)

    @cached_property
    def window_cells(self) -> Mask:
        """Unit cells in any of the windows, shape (n, n)."""
        inside = np.zeros((self.plane.steps,) * 2, bool)
        for i, k, j, m in self.window_nodes:
            inside[i:k, j:m] = True
        return inside

    @property
    def windows(self) -> Sequence[CalmWindow]:
        """Calm windows, the largest first; they may overlap."""
        command = self.plane.command
        return [CalmWindow(*map(Span, command((i, j)), command((k, m)))) for i, k, j, m in self.window_nodes]

    @property
    def window(self) -> CalmWindow | None:
        """Largest calm window."""
        return next(iter(self.windows), None)
