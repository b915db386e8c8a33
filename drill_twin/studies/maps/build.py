# SPDX-License-Identifier: Apache-2.0
"""An operating map from a plan: checks, journal, search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.core.version import __version__
from drill_twin.runs.ensemble import Executor, Threads
from drill_twin.scene import Scene
from drill_twin.studies.maps.check import check
from drill_twin.studies.maps.draws import draws_of
from drill_twin.studies.maps.journal import Journal
from drill_twin.studies.maps.operating_map import OperatingMap, digest_of
from drill_twin.studies.maps.plane import Plane
from drill_twin.studies.maps.prior import growth_of
from drill_twin.studies.maps.runs import Runner
from drill_twin.studies.maps.search import BoundarySearch, Progress

MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class MapPlan:
    """Options of a map.

    Attributes:
        plane: Ranges and lattice.
        duration: Simulated time of a run from rest [s].
        asked: Time for which a calm set-point must stay calm [s].
        seeds: Draws at boundaries, the first of them the scene as it is.
        vary: Least and largest value of uncertain numbers by key, and their unit: `(0.1, 0.3, "")` in SI.
        runs: Largest number of runs.
        hysteresis: Search the boundary at which an existing whirl dies.
        growth: Place first runs by the growth rates of the linear string, where they apply.
        executor: Place where the runs are made.
    """

    plane: Plane
    duration: float
    asked: float
    seeds: int = 1
    vary: Mapping[str, tuple[float, float, str]] = field(default_factory=dict)
    runs: int = 1500
    hysteresis: bool = True
    growth: bool = True
    executor: Executor = field(default_factory=Threads)


def build_map(
    scene: Scene, plan: MapPlan, folder: Path | None = None, progress: Progress = lambda _, __, ___: None
) -> OperatingMap:
    """Make the map of a scene; runs that `folder` has from before are not made again.

    Args:
        scene: The scene, without an accuracy to be resolved.
        plan: How it is made.
        folder: Folder of the journal `runs.jsonl`; None: none is kept.
        progress: Takes the phase, the runs that have ended, and the number expected by now.

    Raises:
        ArgumentError: A range or number is absurd, or the folder has the runs of another map.
        SceneError: A value does not fit the scene, it has no marks, or it plays a record.
        BagError: The folder cannot be written.
    """
    _check(scene, plan)
    draws = draws_of(scene, plan.seeds, plan.vary)
    plane = plan.plane
    setup = {
        "version": __version__, "scene": scene.to_yaml(), "duration": plan.duration, "time asked": plan.asked,
        "range of the weight on bit": list(plane.weight), "range of the speed": list(plane.speed),
        "lattice": plane.steps, "draws": [dict(draw) for draw in draws],
    }  # fmt: skip
    journal = Journal(folder / "runs.jsonl", setup) if folder is not None else None
    runner = Runner(scene, plane, plan.duration, plan.asked, draws, plan.executor)
    growth = growth_of(scene, plane) if plan.growth else None
    search = BoundarySearch(runner, journal, plan.runs, progress, None if growth is None else growth.lateral)
    search.calm()
    search.onset()
    search.regimes()
    if draws:
        search.draws()
    if plan.hysteresis:
        search.end_of_whirl()

    def made() -> OperatingMap:
        lateral, torsional = (None, None) if growth is None else growth
        return OperatingMap(
            scene.name, digest_of(scene), scene.to_yaml(), plane, plan.duration, draws, search.records, search.notes,
            [] if lateral is None else lateral.tolist(), [] if torsional is None else torsional.tolist(), plan.asked,
        )  # fmt: skip

    check(search, made, plan.runs, len(draws))
    return made()


def _check(scene: Scene, plan: MapPlan) -> None:
    plan.plane.checked()
    if not 1 <= plan.runs <= MOST_RUNS:
        raise ArgumentError(f"runs: expected 1 to {MOST_RUNS}, found {plan.runs}")
    if not 0.0 < plan.duration <= 1e6:
        raise ArgumentError(f"duration: expected a time above 0 s and up to 1e6 s, found {plan.duration:g} s")
    if not scene.string.marks:
        raise SceneError(f"{scene.name}: expected marks on the string, from which its motion is judged, found none")
    if scene.rig.start == "whirl-state":
        raise SceneError(f'{scene.name}: expected a run from rest, found rig.start "whirl-state"; --set rig.start=axis')
    if not plan.duration <= plan.asked <= 1e6:
        raise ArgumentError(
            f"calm for: expected a time from that of a run, {plan.duration:g} s, up to 1e6 s, found {plan.asked:g} s"
        )
    for key in ("weight_on_bit", "rotation"):
        if getattr(scene.rig, key).shape == "table":
            raise SceneError(
                f"{scene.name}: expected set-points with a final value, found a recorded {key}; "
                f"--set rig.{key}.shape=ramp --set rig.{key}.value=... replaces it"
            )
