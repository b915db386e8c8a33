# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin estimate`: the estimator over a record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import ArgumentError, RunError
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.scene import Scene
    from drill_twin_studies.estimation import Estimate

FILES = ("estimate.json", "estimate.png")
"""Files of `--out`."""


def estimate(
    record: options.FittedArgument,
    scene: options.FittedOption,
    free: options.FreeOption,
    channel: options.ChannelOption,
    sub: Annotated[
        list[str],
        typer.Option(
            "--sub",
            metavar="NAME",
            help="Correct with this downhole sub of the bag and the scene, or measured/NAME of a rig; repeatable.",
        ),
    ] = [],  # noqa: B006
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    members: Annotated[int, typer.Option("--members", metavar="N", min=4, help="Members of the ensemble.")] = 64,
    window: Annotated[float, options.time_option("--window", "Time from estimate to estimate", 0.05)] = 1.0,
    error: Annotated[
        float,
        typer.Option(
            "--error",
            metavar="SHARE",
            min=1e-6,
            help="Error of a sample, as a share of the largest value of its channel.",
        ),
    ] = 0.02,
    horizon: Annotated[float, options.time_option("--horizon", "Time ahead for the chance of whirl", 0.0)] = 4.0,
    seed: options.SeedOption = 1,
    out: Annotated[Path | None, options.folder_option("Write estimate.json and estimate.png to this folder.")] = None,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Estimate numbers, loads and the chance of whirl along a record, as the node `estimator` does along a rig."""
    import drill_twin as dt
    from drill_twin.scene.records.channels import BLOCK, NULL, channel_column
    from drill_twin_studies.estimation import CHANNELS, SET_POINTS
    from drill_twin_studies.estimation.estimate import HELD
    from drill_twin_studies.estimation.figure import estimate_figure
    from drill_twin_studies.fitting.posterior import of_law

    settings = dt.EstimatorOptions(members=members, window=window, error=error, horizon=horizon, seed=seed)
    ranges = options.ranges_of("--free", free)
    names = [channel_column(text).channel for text in channel]
    measured = [name for name in names if name not in {"time", NULL, BLOCK, *SET_POINTS}]
    if not measured and not sub:
        raise ArgumentError(
            f"--channel: expected a measured channel, {', '.join(CHANNELS)}, found {', '.join(names)} alone; "
            "set-points are only played"
        )
    estimator = dt.Estimator(
        scene, ranges, channels=measured, subs=sub, overrides=options.overrides(change, units=units), options=settings
    )
    over_time: list[Estimate] = []
    alarm = ""
    measurements = dt.read_record(record, channel, subs=sub)
    end = max(float(stamps[-1]) for stamps, _ in measurements.series.values())
    with shown_progress("following the record", end, unit="s") as bar:
        for found in estimator.follow(measurements):
            over_time.append(found)
            bar.show(_line(found), found.time)
            if found.alarm != alarm:
                alarm = found.alarm
                remark(_line(found))
    if not over_time:
        raise RunError(f"{record}: expected more than {window:g} s of record, found less")
    found = over_time[-1]
    troubles = {"troubles": dict(estimator.intake.troubles), "notes": [*measurements.notes]}
    emit(
        _plain(found) | troubles | {"bands": HELD, "of_law": of_law(found.numbers, estimator.scene)},
        (*_shown(found, estimator.scene, estimator.intake.troubles), *measurements.notes),
        json=json, folder=out,
        files={
            FILES[0]: lambda: {"estimates": [_plain(one) for one in over_time], **troubles},
            FILES[1]: lambda: estimate_figure(over_time, measurements, estimator.scene.unit_system),
        },
    )  # fmt: skip


def _shown(found: Estimate, scene: Scene, troubles: Mapping[str, int]) -> Iterator[Table | str]:
    from drill_twin_studies.estimation.estimate import HELD, shown_unit
    from drill_twin_studies.fitting.posterior import of_law, shown_number
    from drill_twin_studies.goodness import table as goodness_table

    yield from filter(None, (found.alarm, found.remembered))
    rows = []
    known = {name: band for name, band in found.sensors.items() if name not in found.withheld}
    for name, band in {**found.numbers, **known}.items():
        size, unit = shown_unit(name, scene.unit_system) if name in found.sensors else shown_number(name, scene)
        mean, low, high = (f"{size * value:.4g}" for value in (band.mean, band.low, band.high))
        rows.append((f"{name} [{unit}]" if unit else name, mean, f"{size * band.deviation:.2g}", low, high))
    title = f"{scene.name} at {found.time:g} s"
    yield Table(("", "mean", "deviation", "low", "high"), rows, title=title, right=(1, 2, 3, 4))
    for reason in dict.fromkeys(found.withheld.values()):
        yield f"{', '.join(name for name, why in found.withheld.items() if why == reason)}: withheld, {reason}"
    for key, share in found.untold.items():
        yield f"{key}: the record does not tell it, its band covers {share:.0%} of its range"
    yield from of_law(found.numbers, scene)
    yield goodness_table(found.goodness)
    yield HELD
    yield _line(found)
    if troubles:
        yield ", ".join(f"{count} {kind}" for kind, count in troubles.items())


def _line(found: Estimate) -> str:
    chance = "" if found.chance != found.chance else f", whirl soon {found.chance:.0%}"
    return f"{found.time:6.1f} s: whirls now {found.whirls:.0%}{chance}" + (f"; {found.alarm}" if found.alarm else "")


def _plain(found: Estimate) -> dict[str, Any]:
    plain = asdict(found)
    del plain["frames"]
    plain["goodness"] = {name: one.to_dict() for name, one in found.goodness.items()}
    return plain | {"alarm": found.alarm, "remembered": found.remembered}
