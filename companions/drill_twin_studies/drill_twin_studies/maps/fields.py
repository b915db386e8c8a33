# SPDX-License-Identifier: Apache-2.0
"""Fields of an operating map over its lattice: regimes, whirl, what is known, growth of the straight string."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field

from drill_twin.core.arrays import Mask
from drill_twin.core.units.system import SYSTEMS, UnitSystem
from drill_twin.scene.load import parse_scene
from drill_twin_studies.maps.plane import UNKNOWN, Labels, Node, Plane, boundary, filled, known_and_calm, on_lattice
from drill_twin_studies.maps.proportions import CONFIDENCE, proportion_interval
from drill_twin_studies.maps.regimes import Regime
from drill_twin_studies.maps.runs import Key, RunOfFile, RunRecord

LIKELY = 0.05
"""Largest upper limit (95 %) of the chance of whirl at a calm set-point, once there are draws enough to show it."""


Number = Annotated[float, Field(ge=-1e15, le=1e15)]
"""Number of a file: no quantity of a string in SI is larger, and the product of two is finite."""
_Grid = Sequence[Sequence[Number]]


class MapFile(BaseModel):
    """Fields of `map.json` that are read; its others are made of them."""

    format: Literal[2]
    scene_name: str
    digest: str
    scene: str
    weight: Annotated[tuple[Number, Number], Field(alias="weight_on_bit_N")]
    speed: Annotated[tuple[Number, Number], Field(alias="rotation_rad_s")]
    steps: int
    duration_s: Annotated[Number, Field(gt=0.0)]
    calm_for_s: Annotated[Number, Field(ge=0.0)]
    draws: Sequence[Mapping[str, Number | str]]
    notes: Sequence[str]
    growth: _Grid
    torsional_growth: _Grid
    runs: Sequence[RunOfFile]


@dataclass(frozen=True)
class MapFields:
    """Runs of a map, and what they show at each node of the lattice.

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
        torsional: The same of a motion about or along the axis; empty in the lateral form.
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
        """Units in which people read the map: those of its scene."""
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
        """Unit cells between runs of the search, shape (n, n); elsewhere the map shows the nearest run, no more."""
        made = np.zeros((self.plane.steps + 1,) * 2, bool)
        for node in self.runs_at_nodes:
            made[node] = True
        return known_and_calm(made, made)[0]

    @cached_property
    def keeps_whirling(self) -> Mask:
        """Nodes at which an existing whirl does not die; those at which it begins from rest included."""
        falling = {key.node: record.whirls for key, record in self.records.items() if key.origin is not None}
        if not falling:
            return self.whirls
        labels = self.plane.labels()
        labels[self.whirls] = 1
        for node, whirls in falling.items():
            labels[node] = max(int(labels[node]), int(whirls))
        return np.asarray(self.whirls | (filled(labels) == 1))

    @property
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
