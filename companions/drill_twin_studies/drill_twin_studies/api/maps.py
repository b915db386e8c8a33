# SPDX-License-Identifier: Apache-2.0
"""Operating map of a scene: regimes over weight on bit and speed (docs/drill_twin_studies/operating_map.md)."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import compress
from pathlib import Path

import numpy as np

from drill_twin.api.ensemble import executor_of
from drill_twin.api.scenes import Overrides, Quantity, as_scene, in_si, range_of, which_fit, with_resolution
from drill_twin.core import __version__
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.core.units.dimension import TIME
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.runs import compile_kernel
from drill_twin.scene import Scene
from drill_twin.scene.overrides import full_key
from drill_twin.scene.schema import number_at
from drill_twin_studies.fitting.sampling import sobol
from drill_twin_studies.maps import OperatingMap, Plane, Span
from drill_twin_studies.maps.grounds import ROUNDS
from drill_twin_studies.maps.runs import FINER, Key, Runner
from drill_twin_studies.maps.search import BoundarySearch, Progress, growth_of, open_journal

STEPS = 128
"""Steps of the lattice along each range: a boundary is located within 1 / 128 of it."""
ASKED = 10.0
"""Time for which a set-point of a window must stay calm, over the time of a run."""
MOST_RUNS = 1_000_000
"""Largest number of runs that can be asked for."""
SEED = "numerics.seed"
MOST_DRAWS = 1000
"""Largest number of draws."""


def draws_of(scene: Scene, seeds: int, vary: Mapping[str, tuple[float, float]]) -> tuple[Mapping[str, float], ...]:
    """Values by key of each draw that the scene takes; empty where one draw is asked for and nothing varies.

    The points of a scrambled Sobol sequence (Owen 1998) fill the ranges.

    Args:
        scene: The base scene; its own numbers are the first draw.
        seeds: Number of draws.
        vary: Least and largest value in SI by full key.

    Raises:
        ArgumentError: Too many draws, ranges for one, or ranges of which no draw fits together.
    """
    if not 1 <= seeds <= MOST_DRAWS:
        raise ArgumentError(f"seeds: expected 1 to {MOST_DRAWS}, found {seeds}")
    if vary and seeds == 1:
        raise ArgumentError("vary: expected 2 or more seeds with uncertain numbers, one draw each; found 1")
    if seeds == 1:
        return ()
    draws = [{SEED: scene.numerics.seed} | {key: number_at(scene, key) or 0.0 for key in vary}]
    points = sobol(max(1, len(vary)), seeds, 0)
    for number, point in enumerate(points[:-1].tolist(), 1):
        shares = zip(point, vary.items(), strict=False)
        draws.append(
            {SEED: scene.numerics.seed + number}
            | {key: low + (high - low) * share for share, (key, (low, high)) in shares}
        )
    return (draws[0], *compress(draws[1:], which_fit(scene, draws[1:])))


MOST_CHECKS, RUNS_FOR_ONE = 59, 20
"""Checks of a round: 59 of 59 show that at most 7.2 % are not calm (95 %, with `ROUNDS` rounds); at most one for so
many runs of a map."""


def check(search: BoundarySearch, made: Callable[[], OperatingMap], runs: int, draws: int) -> int:
    """Check the windows; each check that fails makes them smaller, and a new round begins.

    Returns:
        Number of checks of a last round without failure; 0 if there was none.

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
            return 0
        random = np.random.default_rng(number)
        places = cells[random.integers(len(cells), size=count)] * FINER + random.integers(FINER + 1, size=(count, 2))
        keys = [Key(i, j, k % max(1, draws), None, FINER) for k, (i, j) in enumerate(places.tolist())]
        search.make("check of the windows", keys, beyond=True)
        if all(search.records[key].calm for key in keys):
            return count
    return 0


def operating_map(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    wob: str,
    rpm: str,
    seeds: int = 1,
    vary: Mapping[str, str] | None = None,
    duration: Quantity | None = None,
    calm_for: Quantity | None = None,
    runs: int = 1500,
    hysteresis: bool = True,
    growth: bool = True,
    steps: int = STEPS,
    folder: str | Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress | None = None,
) -> OperatingMap:
    """Regimes of motion over weight on bit and speed, from runs that crowd where the regime changes.

    >>> found = operating_map("pa6_bench", wob="1..300 N", rpm="60..390")
    >>> found.regime("40 N", "2 rev/s"), found.margin("40 N", "2 rev/s"), found.windows, found.basis

    Args:
        scene: The scene, or its name or file; each run begins as it does.
        overrides: Values that replace the scene's values.
        wob: Range of the weight on bit, `"1..300 N"`.
        rpm: Range of the rotation, `"60..390"` [rev/min] or with a unit.
        seeds: Draws along the onset of whirl, the first of them the scene as it is.
        vary: Ranges of uncertain numbers by key, `{"wall_friction.coefficient": "0.1..0.3"}`.
        duration: Simulated time of a run from rest [s]; left out: the scene's.
        calm_for: Time for which a set-point of a window must stay calm [s]; left out: ten times the duration.
        runs: Largest number of runs of the search; checks of the windows, of that time each, come to it.
        hysteresis: Search the second boundary, where an existing whirl dies.
        growth: Place first runs by the growth rates of the linear string, where they apply.
        steps: Steps of the lattice along each range, a power of 2.
        folder: Folder of `runs.jsonl`; a map that was broken off goes on from it, and ends with the same bits.
        workers: Threads; by default one for each processor core.
        dask: Address of a Dask scheduler, on whose workers the runs are made instead.
        progress: Called with the phase, the runs that have ended, and the number expected by now.

    Raises:
        ArgumentError: A range or number is absurd, the folder has the runs of another map, or the block is moved by its
            speed.
        SceneError: The scene cannot be loaded, has no marks or plays a record, or a value does not fit it.
        BagError: The folder cannot be written.
        RunError: The scheduler or its workers cannot make runs.
    """
    own = with_resolution(as_scene(scene, overrides))
    _check_scene(own)
    plane = Plane(Span(*range_of(own, "wob", wob)), Span(*range_of(own, "rpm", rpm)), steps).checked()
    if plane.speed.low < 0.0:
        raise ArgumentError(f'rpm: expected speeds from 0 upwards, found "{str(rpm)[:60]}"; a map is of one sense')
    length = own.rig.duration if duration is None else in_si("duration", duration, TIME)
    asked = ASKED * length if calm_for is None else in_si("calm_for", calm_for, TIME)
    ranges = {full_key(key, own): range_of(own, key, given) for key, given in (vary or {}).items()}
    if not 1 <= runs <= MOST_RUNS:
        raise ArgumentError(f"runs: expected 1 to {MOST_RUNS}, found {runs}")
    if not 0.0 < length <= 1e6:
        raise ArgumentError(f"duration: expected a time above 0 s and up to 1e6 s, found {length:g} s")
    if not length <= asked <= 1e6:
        raise ArgumentError(
            f"calm_for: expected a time from a run's length, {length:g} s, up to 1e6 s, found {asked:g} s"
        )
    draws = draws_of(own, seeds, ranges)
    setup = {
        "version": __version__, "scene": own.model_copy(update={"units": "auto"}).to_yaml(), "duration": length,
        "time asked": asked, "range of the weight on bit": list(plane.weight), "range of the speed": list(plane.speed),
        "lattice": plane.steps, "draws": [dict(draw) for draw in draws],
    }  # fmt: skip
    with executor_of(workers, dask) as executor:
        compile_kernel(own, own.numerics.frame_period, analysis=True)
        journal = None if folder is None else open_journal(Path(folder), setup)
        rates = growth_of(own, plane) if growth else None
        lateral, torsional = (None, None) if rates is None else (rates.lateral, rates.torsional)
        runner = Runner(own, plane, length, asked, draws, executor)
        search = BoundarySearch(runner, journal, runs, progress or (lambda _, __, ___: None), lateral)
        if lost := len(draws) and seeds - len(draws):
            search.notes.append(f"{lost} of {seeds} draws left out: the scene does not take their numbers together")
        if own.rig.start in {"rotating", "equilibrium"}:
            search.notes.append(
                f'"from rest" is here at speed and in balance (rig.start: {own.rig.start}): motion that only a push '
                "begins is not found; --set rig.start=axis begins at rest"
            )
        search.calm()
        search.onset()
        search.regimes()
        if draws:
            search.draws()
        if hysteresis:
            search.end_of_whirl()

        def made() -> OperatingMap:
            return OperatingMap(
                own.name, digest_of(own), own.to_yaml(), plane, length, draws, search.records, search.notes,
                [] if lateral is None else lateral.tolist(), [] if torsional is None else torsional.tolist(), asked,
            )  # fmt: skip

        return replace(made(), clean_checks=check(search, made, runs, len(draws)))


def _check_scene(scene: Scene) -> None:
    """Refuse a scene that has no map.

    Raises:
        ArgumentError: The block is moved by its speed.
        SceneError: The scene has no marks, begins in a whirl, or plays recorded set-points.
    """
    if scene.rig.block is not None and scene.rig.block.auto_driller is None:
        raise ArgumentError(
            f"{scene.name}: expected a load as set-point, found a block moved by its speed, under which there is none "
            "to vary; use `rig.weight_on_bit.at: bit`, or an auto-driller"
        )
    for key in ("weight_on_bit", "rotation"):
        if getattr(scene.rig, key).shape == "table":
            raise SceneError(
                f"{scene.name}: expected set-points with a final value, found a recorded {key}; "
                f"--set rig.{key}.shape=ramp --set rig.{key}.value=... replaces it"
            )
    if not scene.string.marks:
        raise SceneError(f"{scene.name}: expected marks on the string, from which its motion is judged, found none")
    if scene.rig.start == "whirl-state":
        raise SceneError(f'{scene.name}: expected a run from rest, found rig.start "whirl-state"; --set rig.start=axis')
