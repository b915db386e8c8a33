# SPDX-License-Identifier: Apache-2.0
"""Fields of an operating map over its lattice, and its safe windows: rectangles of set-points that stay calm.

The plane is judged in cells of one step. A cell is safe if
* it lies in a cell of the search whose four corners have runs, all of them smooth in all their draws (a run that has
  not settled is not smooth); the smallest such cell decides;
* the linear string does not grow at any of its corners, where its growth is known;
* a whirl that exists dies in it, where the end of whirls was searched;
* no check in it failed: a run of the whole time asked;
* it keeps `MARGIN` to the next cell that is not safe.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Mask
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
    filled,
    known_and_calm,
    on_lattice,
    rectangles,
)
from drill_twin_studies.maps.proportions import CONFIDENCE, proportion_interval
from drill_twin_studies.maps.regimes import Regime
from drill_twin_studies.maps.runs import Key, RunRecord

LIKELY = 0.05
"""Largest upper limit (95 %) of the chance of whirl at a calm set-point, once there are draws enough to show it."""


MARGIN = 0.02
"""Distance that a window keeps to what is not safe, as a share of the ranges; not measured."""


class SafeWindow(NamedTuple):
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
        made = self._smooth != UNKNOWN
        return known_and_calm(made, made)[0]

    @cached_property
    def _smooth(self) -> Labels:
        """1 for nodes whose runs are all smooth, in all their draws; 0 for other nodes with runs."""
        labels = self.plane.labels()
        for node, runs in self.runs_at_nodes.items():
            labels[node] = all(record.regime is Regime.SMOOTH for record in runs)
        return labels

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
        """Nodes that are smooth from rest in all draws, at which the straight string does not grow."""
        calm = (self.regimes == Regime.SMOOTH.code) & ~self.whirls
        if len(self.growth):
            calm &= on_lattice(np.array(self.largest_growth), self.plane.steps) <= 0.0
        return np.asarray(calm)

    @property
    def has_second_boundary(self) -> bool:
        """The map has runs in which a whirl may die."""
        return any(key.origin is not None for key in self.records)

    @property
    def largest_growth(self) -> Sequence[Sequence[float]]:
        """Largest growth of any motion of the straight string at the nodes of an even grid [1/s]."""
        return np.maximum(self.growth, self.torsional).tolist() if len(self.torsional) else self.growth

    @property
    def checks(self) -> Sequence[tuple[Key, RunRecord]]:
        """Runs of the whole time asked at set-points drawn in the windows."""
        return [(key, record) for key, record in self.records.items() if key.finer > 1]

    def lines(self, flags: Mask) -> list[list[list[float]]]:
        """Boundary of flagged nodes: segments of two points, weight on bit [N] and speed [rad/s]."""
        return [[list(self.plane.command((float(x), float(y)))) for x, y in ends] for ends in boundary(flags)]

    @property
    def safe_cells(self) -> Mask:
        """Unit cells that are safe, shape (n, n)."""
        from scipy.ndimage import distance_transform_edt

        steps = self.plane.steps
        good = known_and_calm(self._smooth != UNKNOWN, self._smooth == 1)[1]
        if len(self.growth):
            good &= corners(on_lattice(np.array(self.largest_growth), steps)).max(axis=0) <= 0.0
        if self.has_second_boundary:
            good &= ~corners(self.keeps_whirling).any(axis=0)
        for key, record in self.checks:
            if record.regime is not Regime.SMOOTH:
                good[self.plane.cells_at(key.place)] = False
        if good.all():
            return good
        return np.asarray(distance_transform_edt(good) > MARGIN * steps + 0.5)

    @property
    def clean_checks(self) -> int:
        """Checks in the windows since the last check that was not smooth."""
        count, inside = 0, self.window_cells
        for key, record in self.checks:
            here = inside[self.plane.cells_at(key.place)].any()
            count = 0 if record.regime is not Regime.SMOOTH else count + int(here)
        return count

    @cached_property
    def window_nodes(self) -> Sequence[tuple[int, int, int, int]]:
        """First and last node of each safe window along weight on bit and speed."""
        return rectangles(self.safe_cells)

    @cached_property
    def window_cells(self) -> Mask:
        """Unit cells in any of the windows, shape (n, n)."""
        inside = np.zeros((self.plane.steps,) * 2, bool)
        for i, k, j, m in self.window_nodes:
            inside[i:k, j:m] = True
        return inside

    @property
    def windows(self) -> Sequence[SafeWindow]:
        """Safe windows, the largest first; they may overlap."""
        command = self.plane.command
        return [SafeWindow(*map(Span, command((i, j)), command((k, m)))) for i, k, j, m in self.window_nodes]

    @property
    def window(self) -> SafeWindow | None:
        """Largest safe window."""
        return next(iter(self.windows), None)

    @property
    def basis(self) -> Sequence[str]:
        """Grounds of the windows, as sentences; empty without windows."""
        inside = self.window_cells
        if not inside.any():
            return []
        steps = self.plane.steps
        nodes = np.asarray(corners(np.pad(inside, 1)).any(axis=0))
        runs = sum(len(runs) for node, runs in self.runs_at_nodes.items() if nodes[node])
        runs_said = (
            f"{runs} runs of {self.duration:g} s in them and at their corners, all smooth: none would whirl or swing "
            f"within {self.asked:g} s if it went on growing as at its end"
        )
        said = [runs_said]
        if len(self.growth):
            largest = float(on_lattice(np.array(self.largest_growth), steps)[nodes].max())
            said.append(f"the straight string does not grow anywhere in them (largest rate {largest:.2g} 1/s)")
        else:
            said.append("linear growth is not known for this scene, so nothing is known between its runs")
        said.append(
            "a whirl that exists dies in them, on the way that was tried"
            if self.has_second_boundary
            else "whether a whirl that exists dies in them was not searched"
        )
        if len(self.draws) > 1:
            shown = proportion_interval(0, len(self.draws), CONFIDENCE)[1]
            said.append(
                f"no draw whirls at their set-points with {len(self.draws)} draws: each of them whirls with a chance "
                f"below {shown:.1%} (95 %)"
            )
        if count := self.clean_checks:
            most = proportion_interval(0, count, CONFIDENCE)[1]
            said.append(
                f"{count} more runs of {self.asked:g} s at set-points drawn in them are smooth: at most {most:.1%} of "
                "their set-points are not (95 %)"
            )
        else:
            said.append(
                f"no run of {self.asked:g} s was made in them, so what share of their set-points is calm is not known"
            )
        said.append(
            f"they keep {MARGIN:.0%} of the ranges to all that is not safe or not known; nothing of this is of a rig"
        )
        return said
