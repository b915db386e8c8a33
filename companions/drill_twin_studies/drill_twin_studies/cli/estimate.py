# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin estimate`: the estimator over a record."""

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import ArgumentError, RunError


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
    from drill_twin_studies.estimation.figure import estimate_figure, line, plain, shown
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
    over_time = []
    alarm = ""
    measurements = dt.read_record(record, channel, subs=sub)
    end = max(float(stamps[-1]) for stamps, _ in measurements.series.values())
    with shown_progress("following the record", end, unit="s") as bar:
        for found in estimator.follow(measurements):
            over_time.append(found)
            bar.show(line(found), found.time)
            if found.alarm != alarm:
                alarm = found.alarm
                remark(line(found))
    if not over_time:
        raise RunError(
            f"{record}: expected a record longer than --window ({window:g} s), found less; take a shorter window"
        )
    troubles = {"troubles": dict(estimator.intake.troubles), "notes": [*measurements.notes]}
    emit(
        plain(found) | troubles | {"bands": HELD, "of_law": of_law(found.numbers, estimator.scene)},
        (*shown(found, estimator.scene, estimator.intake.troubles), *measurements.notes),
        json=json, folder=out,
        files={
            "estimate.json": lambda: {"estimates": [plain(one) for one in over_time], **troubles},
            "estimate.png": lambda: estimate_figure(over_time, measurements, estimator.scene.unit_system),
        },
    )  # fmt: skip
