# SPDX-License-Identifier: Apache-2.0
"""Operating map of a scene: regimes over weight on bit and speed (docs/drill_twin_studies/operating_map.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from drill_twin.api.ensemble import executor_of
from drill_twin.api.scenes import Overrides, Quantity, as_scene, in_si, range_of
from drill_twin.core.errors import ArgumentError
from drill_twin.core.units.dimension import TIME
from drill_twin.runs import compile_kernel
from drill_twin.scene import Scene
from drill_twin.scene.overrides import full_key
from drill_twin_studies.maps import MapPlan, OperatingMap, Plane, Span, build_map
from drill_twin_studies.maps.build import check_set_points

STEPS = 128
"""Steps of the lattice along each range: a boundary is located within 1 / 128 of it."""
ASKED = 10.0
"""Time for which a set-point of a safe window must stay calm, over that of a run."""


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
    progress: Callable[[str, int, int], None] | None = None,
) -> OperatingMap:
    """Regimes of motion over weight on bit and speed, from runs that crowd where the regime changes.

    >>> found = operating_map("pa6_bench", wob="1..300 N", rpm="60..390")
    >>> found.regime(40.0, 12.6), found.margin(40.0, 12.6), found.windows, found.basis

    Args:
        scene: The scene, or its name or file; each run begins as it does.
        overrides: Values that replace those of the scene.
        wob: Range of the weight on bit, `"1..300 N"`.
        rpm: Range of the rotation, `"60..390"` [rev/min] or with a unit.
        seeds: Draws along the onset of whirl, the first of them the scene as it is.
        vary: Ranges of uncertain numbers by key, `{"wall_friction.coefficient": "0.1..0.3"}`.
        duration: Simulated time of a run from rest [s]; left out: that of the scene.
        calm_for: Time for which a set-point of a safe window must stay calm [s]; left out: ten times the duration.
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
    own = as_scene(scene, overrides)
    if own.numerics.accuracy is not None:
        from drill_twin.studies.accuracy import resolve

        own = resolve(own).scene
    if own.rig.block is not None and own.rig.block.auto_driller is None:
        raise ArgumentError(
            f"{own.name}: expected a load as set-point, found a block moved by its speed, under which there is none to "
            "vary; use `rig.weight_on_bit.at: bit`, or an auto-driller"
        )
    check_set_points(own)
    plane = Plane(Span(*range_of(own, "wob", wob)), Span(*range_of(own, "rpm", rpm)), steps).checked()
    if plane.speed.low < 0.0:
        raise ArgumentError(f'rpm: expected speeds from 0 upwards, found "{str(rpm)[:60]}"; a map is of one sense')
    length = own.rig.duration if duration is None else in_si("duration", duration, TIME)
    asked = ASKED * length if calm_for is None else in_si("calm_for", calm_for, TIME)
    ranges = {full_key(key, own): range_of(own, key, given) for key, given in (vary or {}).items()}
    place = None if folder is None else Path(folder)
    with executor_of(workers, dask) as executor:
        plan = MapPlan(plane, length, asked, seeds, ranges, runs, hysteresis, growth, executor)
        compile_kernel(own, own.numerics.frame_period, analysis=True)
        return build_map(own, plan, place, *([progress] if progress is not None else []))
