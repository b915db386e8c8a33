# SPDX-License-Identifier: Apache-2.0
"""Fit of a scene's numbers to a record (docs/drill_twin_studies/fit.md)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from drill_twin.api.ensemble import Ensemble
from drill_twin.api.scenes import Overrides, Quantity, as_scene, in_si, range_of, which_fit
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, RunError
from drill_twin.core.rig_channels import INSTANT
from drill_twin.core.units.dimension import FREQUENCY, TIME
from drill_twin.scene import Scene
from drill_twin.scene.overrides import full_key
from drill_twin_studies.fitting import (
    CHANNELS,
    SET_POINTS,
    Posterior,
    Record,
    Sampling,
    of_features,
    of_series,
    read_record,
    sample,
)
from drill_twin_studies.fitting.sampling import in_ranges
from drill_twin_studies.goodness import FEWEST


def fit(
    record: Record | str | Path,
    scene: Scene | str | Path,
    free: Mapping[str, str | tuple[float, float]],
    *,
    channels: Sequence[str] = (),
    overrides: Overrides | None = None,
    likelihood: str = "series",
    begin: Quantity = 0.0,
    end: Quantity | None = None,
    rate: Quantity = 20.0,
    window: Quantity = 5.0,
    members: int = 64,
    rounds: int = 24,
    effective: float = 200.0,
    seed: int = 1,
    workers: int | None = None,
    progress: Callable[[int, Sampling], None] | None = None,
) -> Posterior:
    """Find the numbers of a scene that explain a record, and how well the record determines them.

    >>> found = fit("rig.csv", "two_mass", {"bit_torque_stribeck.sticking": "0.4..1.2"}, channels=["bit_speed=rpm:rpm"])
    >>> found.best, found.undetermined, found.scene_text()

    Args:
        record: Record, or a CSV, MAT, LAS or WITSML file or a bag with `channels`.
        scene: The scene. Set-points among `channels` are played, as `estimate` does; others are the scene's.
        free: Range of each number by key: "0.05..0.5", with units where they are needed ("1 s/m..1e3 s/m"), or SI.
            The prior is uniform, in the logarithm if the ends are positive and differ by a factor of 20 or more.
            Draws that the scene does not take together have no weight.
        channels: Columns of a file, as `drill_twin_studies.fitting.record.channel_column` parses them; of a bag,
            names of channels. A sample is a mean since the last sample; of "torque@instant", a value at its time.
        overrides: Values that replace the scene's values.
        likelihood: "series", or "features" of windows, where the phase of the motion is not determined.
        begin: Time from which record and runs are compared [s].
        end: Time to which they are, and length of the runs [s]; left out: the end of the scene.
        rate: Samples that are compared per second [Hz].
        window: Length of a window of "features" [s].
        members: Runs of a round.
        rounds: Rounds at most.
        effective: Effective number of draws with which it ends.
        seed: Of the draws.
        workers: Threads; by default one for each processor core.
        progress: Called after each round with its number and the draws so far.

    Raises:
        ArgumentError: An argument cannot be used.
        SceneError: A range does not fit the scene.
        TableError: The record cannot be read.
        BagError: The bag cannot be read.
        RunError: No run could be followed to the end.
    """
    base = as_scene(scene, overrides)
    found = record if isinstance(record, Record) else read_record(record, channels)
    ranges = {key: range_of(base, key, given, free) for key, given in free.items()}
    places = [full_key(key, base) for key in ranges]
    if not ranges or likelihood not in {"series", "features"}:
        raise ArgumentError(
            f"fit: expected a range of at least one number and a likelihood of series, features, "
            f'found {len(ranges)} and "{likelihood}"'
        )
    if played := {name: found.series[name] for name in sorted(SET_POINTS & found.series.keys())}:
        note = f"{', '.join(played)}: played, not compared; fitted.yaml has the set-points of the scene"
        series = {name: each for name, each in found.series.items() if name not in SET_POINTS}
        found = replace(found, series=series, notes=[*found.notes, note])
    if not found.series:
        raise ArgumentError(f"fit: expected a channel of a run, {', '.join(CHANNELS)}, found none")
    if idle := [place for place in places if place.startswith(tuple(f"rig.{name}." for name in played))]:
        raise ArgumentError(
            f"fit: expected a number that the run takes, found {idle[0]}: the record is played in its place"
        )
    length = base.rig.duration if end is None else in_si("end", end, TIME)
    frequency, first = in_si("rate", rate, FREQUENCY), in_si("begin", begin, TIME)
    if (length - first) * min(frequency, base.numerics.frame_rate) < FEWEST:
        raise ArgumentError(
            f"fit: expected {FEWEST} samples or more to compare, found samples from {first:g} s to {length:g} s at "
            f"{frequency:g} Hz; choose another time to begin or to end"
        )
    size = in_si("window", window, TIME)
    merged: dict[str, Array] = {}
    time: Array = np.zeros(0)
    measured: dict[str, Array] = {}
    failed = refused = 0

    def evaluate(cube: Array) -> Array:
        nonlocal time, measured, merged, failed, refused
        drawn = in_ranges(cube, ranges)
        fits = which_fit(base, (dict(zip(places, row, strict=True)) for row in drawn.tolist()))
        vary = {key: drawn[fits, place].tolist() for place, key in enumerate(ranges)}
        outputs = ("channels", "instants") if found.instant else ("channels",)
        runs = Ensemble(base, vary, zipped=True).run(
            length, outputs=outputs, mark_rate=frequency, workers=workers, played=played
        )
        failed += len(runs.failed)
        refused += fits.count(False)
        if not measured:
            time = runs["time"][runs["time"] >= first]
            measured = {channel: found.at(channel, time) for channel in found.series}
        computed = {name: f"{name}{INSTANT}" if name in found.instant else name for name in measured}
        batch = {name: np.full((len(fits), time.size), np.nan) for name in computed}
        for name, output in computed.items():
            batch[name][fits] = runs[output][:, -time.size :]
        merged = {name: np.concatenate((merged[name], new) if merged else (new,)) for name, new in batch.items()}
        if likelihood == "series":
            result = of_series(measured, merged, len(ranges))
        else:
            result = of_features(measured, merged, float(time[1] - time[0]), size)
        if not np.isfinite(result).any():
            raise RunError(
                f"fit: no run of {failed} could be followed to {length:g} s: {next(iter(runs.failed.values()))}"
            )
        return np.where(np.isfinite(result), result, -np.inf)

    sampling = sample(
        evaluate, len(ranges), members=members, rounds=rounds, effective=effective, seed=seed, done=progress
    )
    drawn = in_ranges(sampling.cube, ranges)
    if refused:
        note = f"{refused} of {len(drawn)} draws left out: the scene does not take their numbers together"
        found = replace(found, notes=[*found.notes, note])
    windows = size if likelihood == "features" else None
    return Posterior(base, ranges, drawn, sampling, found, time, measured, merged, failed, windows)
