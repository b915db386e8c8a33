# SPDX-License-Identifier: Apache-2.0
"""An operating map from a plan: draws, search, checks of the safe windows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drill_twin.core import __version__
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.runs.ensemble import Executor, Threads
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin_studies.maps.operating_map import OperatingMap
from drill_twin_studies.maps.plane import Plane
from drill_twin_studies.maps.regimes import Regime
from drill_twin_studies.maps.runs import FINER, Key, Runner
from drill_twin_studies.maps.search import BoundarySearch, Progress, growth_of, open_journal

SEED = "numerics.seed"
MOST_DRAWS = 1000
"""Largest number of draws."""


def draws_of(scene: Scene, seeds: int, vary: Mapping[str, tuple[float, float]]) -> tuple[Mapping[str, float], ...]:
    """Values by key of each draw; empty where one draw is asked for and nothing varies.

    The points of a scrambled Sobol sequence (Owen 1998) fill the ranges.

    Args:
        scene: The base scene; its own numbers are the first draw.
        seeds: Number of draws.
        vary: Least and largest value in SI by full key.

    Raises:
        ArgumentError: Too many draws, or ranges for one.
    """
    if not 1 <= seeds <= MOST_DRAWS:
        raise ArgumentError(f"seeds: expected 1 to {MOST_DRAWS}, found {seeds}")
    if vary and seeds == 1:
        raise ArgumentError("vary: expected 2 or more seeds with uncertain numbers, one draw for each; found 1")
    if seeds == 1:
        return ()
    from scipy.stats import qmc

    draws = [{SEED: scene.numerics.seed} | {key: number_at(scene, key) or 0.0 for key in vary}]
    points = qmc.Sobol(max(1, len(vary)), seed=0).random(1 << (seeds - 1).bit_length())
    for number, point in enumerate(points[: seeds - 1].tolist(), 1):
        shares = zip(point, vary.items(), strict=False)
        draws.append(
            {SEED: scene.numerics.seed + number}
            | {key: low + (high - low) * share for share, (key, (low, high)) in shares}
        )
    return tuple(draws)


MOST_CHECKS, RUNS_FOR_ONE = 59, 20
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
    count = min(MOST_CHECKS, runs // RUNS_FOR_ONE)
    for number in range(ROUNDS):
        cells = np.argwhere(made().window_cells)
        if not (count and cells.size):
            return
        random = np.random.default_rng(number)
        places = cells[random.integers(len(cells), size=count)] * FINER + random.integers(FINER + 1, size=(count, 2))
        keys = [Key(i, j, k % max(1, draws), None, FINER) for k, (i, j) in enumerate(places.tolist())]
        search.make("check of the windows", keys, beyond=True)
        if all(search.records[key].regime is Regime.SMOOTH for key in keys):
            return


MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class MapPlan:
    """Options of a map.

    Attributes:
        plane: Ranges and lattice.
        duration: Simulated time of a run from rest [s].
        asked: Time for which a calm set-point must stay calm [s].
        seeds: Draws at boundaries, the first of them the scene as it is.
        vary: Least and largest value of uncertain numbers by key, in SI: `(0.1, 0.3)`.
        runs: Largest number of runs.
        hysteresis: Search the boundary at which an existing whirl dies.
        growth: Place first runs by the growth rates of the linear string, where they apply.
        executor: Place where the runs are made.
    """

    plane: Plane
    duration: float
    asked: float
    seeds: int = 1
    vary: Mapping[str, tuple[float, float]] = field(default_factory=dict)
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
    plane, numbers = plan.plane, scene.model_copy(update={"units": "auto"}).to_yaml()  # units change no run
    setup = {
        "version": __version__, "scene": numbers, "duration": plan.duration, "time asked": plan.asked,
        "range of the weight on bit": list(plane.weight), "range of the speed": list(plane.speed),
        "lattice": plane.steps, "draws": [dict(draw) for draw in draws],
    }  # fmt: skip
    journal = open_journal(folder, setup) if folder is not None else None
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


def check_set_points(scene: Scene) -> None:
    """Check that the set-points of a scene have final values, which a map can vary.

    Raises:
        SceneError: One is recorded.
    """
    for key in ("weight_on_bit", "rotation"):
        if getattr(scene.rig, key).shape == "table":
            raise SceneError(
                f"{scene.name}: expected set-points with a final value, found a recorded {key}; "
                f"--set rig.{key}.shape=ramp --set rig.{key}.value=... replaces it"
            )
