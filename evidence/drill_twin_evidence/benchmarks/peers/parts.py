# SPDX-License-Identifier: Apache-2.0
"""The parts of the comparison: which runs, and what counts as the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from drill_twin_evidence.benchmarks.peers.task import ABOVE, HARD, SMOOTH, Task

OURS, EXUDYN, MUJOCO, PYELASTICA = "drill_twin", "Exudyn ANCF", "MuJoCo flex", "PyElastica"
MS = 1e-3
_LOOSE = {"numerics.tolerance": "1e-4"}  # without contact one iteration is enough anyway
Rungs = Mapping[str, Sequence[tuple[int, float]]]
"""Tool -> elements and step [ms]; 0 = the tool's own choice."""


class Part(NamedTuple):
    """Runs that belong into one table."""

    name: str
    title: str
    tasks: tuple[Task, ...]
    reference: Task | None
    """Against which errors are counted."""
    check: Task | None
    """The same by another tool: how far the two are apart bounds what an error can tell."""


def _tasks(rungs: Rungs, changes: Mapping[str, str], *, scene: str = "peers", limit: float = 60.0) -> tuple[Task, ...]:
    return tuple(
        Task(tool, elements, step * MS, scene, changes, _LOOSE if tool == OURS else {}, limit)
        for tool, ladder in rungs.items()
        for elements, step in ladder
    )


_PLUCK: Rungs = {
    OURS: [(8, 10), (8, 5), (12, 5), (12, 2), (16, 2), (16, 1), (24, 1), (32, 1), (32, 0.5)],
    EXUDYN: [(8, 10), (8, 5), (16, 5), (16, 2), (32, 2), (32, 1), (64, 1), (64, 0.5)],
    MUJOCO: [(20, 5), (50, 5), (50, 1), (50, 0.2), (100, 0.2), (100, 0.1), (100, 0.05)],
    PYELASTICA: [(20, 0), (50, 0), (100, 0), (200, 0.0075)],
}
_BUCKLED: Rungs = {
    OURS: [(12, 5), (16, 5), (16, 2), (24, 2), (32, 2), (32, 1), (64, 1)],
    EXUDYN: [(16, 5), (16, 2), (32, 5), (32, 2), (64, 2), (64, 1)],
    MUJOCO: [(50, 5), (50, 1), (50, 0.2), (100, 0.2)],
    PYELASTICA: [(50, 0), (100, 0)],
}
_CONTACT: Rungs = {
    OURS: [(12, 5), (16, 5), (16, 2), (24, 2), (32, 2), (50, 2), (50, 1), (200, 1)],
    EXUDYN: [(12, 5), (16, 5), (16, 2), (20, 1), (50, 2), (50, 1), (200, 1)],
    MUJOCO: [(20, 5), (50, 5), (50, 1), (50, 0.2), (200, 1)],
    PYELASTICA: [(50, 0), (50, 0.005), (200, 0.005)],
}
_HARD: Rungs = {
    OURS: [(50, 0), (50, 2), (50, 1)],
    MUJOCO: [(50, 1), (50, 5)],
    EXUDYN: [(50, 1)],
    PYELASTICA: [(50, 0), (50, 0.005)],
}
_STEEL: Rungs = {OURS: [(250, 0)], MUJOCO: [(100, 1), (250, 1)], EXUDYN: [(100, 1)], PYELASTICA: [(100, 0)]}


_PLAIN = (
    Task(MUJOCO, 50, 1.0 * MS, changes=SMOOTH, options={"plain": True}),
    Task(PYELASTICA, 50, 0.0, changes=SMOOTH, options={"plain": True}),
)


def _fine(tool: str, elements: int, step: float, changes: Mapping[str, str]) -> Task:
    return Task(tool, elements, step * MS, changes=changes, limit=600.0)


_UNTIL_CONTACT = {"duration": "0.8 s"}
PARTS = {
    part.name: part
    for part in (
        Part("smooth", "Smooth motion: a pluck of 0.3 m/s, 1 s, no load", (*_tasks(_PLUCK, SMOOTH), *_PLAIN),
             _fine(OURS, 96, 0.1, SMOOTH), _fine(EXUDYN, 128, 0.2, SMOOTH)),
        Part("buckled", "The same under 40 N, three times the buckling load, 0.8 s", _tasks(_BUCKLED, ABOVE),
             _fine(OURS, 128, 0.1, ABOVE), _fine(EXUDYN, 128, 0.2, ABOVE)),
        Part("contact", "The peers' scene: 40 N, 2 rev/s, wall and friction, 5 s", _tasks(_CONTACT, {}),
             _fine(OURS, 128, 0.1, _UNTIL_CONTACT), _fine(EXUDYN, 128, 0.2, _UNTIL_CONTACT)),
        Part("hard", "300 N and 6.5 rev/s, wall and friction, 30 s", _tasks(_HARD, HARD), None, None),
        Part("steel", "500 m of steel, 160 kN, 50 rpm, wall and friction, 10 s",
             (*_tasks(_STEEL, {}, scene="steel"),
              *(Task(OURS, 250, step, "bha_full_size", options=_LOOSE) for step in (0.0, 10.0 * MS))), None, None),
    )
}  # fmt: skip
"""By name."""
