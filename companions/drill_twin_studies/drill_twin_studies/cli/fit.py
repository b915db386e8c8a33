# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin fit`: numbers of a scene from a record."""

import math
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress


def fit(
    record: options.FittedArgument,
    scene: options.FittedOption,
    free: options.FreeOption,
    channel: options.ChannelOption,
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    likelihood: Annotated[
        str,
        typer.Option(
            "--likelihood", metavar="series|features", help="What is compared: the series, or features of windows."
        ),
    ] = "series",
    begin: options.FromOption = 0.0,
    end: options.ToOption = math.inf,
    rate: Annotated[str, typer.Option("--rate", metavar="FREQUENCY", help="Samples compared per second.")] = "20 Hz",
    window: Annotated[
        float, options.time_option("--window", "With --likelihood features: length of a window", 0.0)
    ] = 5.0,
    members: Annotated[int, typer.Option("--members", metavar="N", min=8, help="Runs in a round.")] = 64,
    rounds: Annotated[int, typer.Option("--rounds", metavar="N", min=1, help="Most rounds.")] = 24,
    seed: options.SeedOption = 1,
    workers: options.WorkersOption = 0,
    out: Annotated[
        Path | None, options.folder_option("Write fit.json, fitted.yaml and fit.png to this folder.")
    ] = None,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Find numbers of a scene from a record, with intervals, correlations, and what the record does not determine."""
    import drill_twin as dt
    from drill_twin_studies.fitting import Sampling
    from drill_twin_studies.fitting.figures import fit_figure, shown

    ranges = options.ranges_of("--free", free)

    with shown_progress("running the first round", rounds, unit="rounds", most=True) as bar:

        def told(number: int, found: Sampling) -> None:
            power = "" if found.power == 1.0 else f", likelihood to the power {found.power:.2g}"
            bar.show(f"{found.effective:.0f} effective draws of {len(found.weights)}{power}", number)

        found = dt.fit(
            record, scene, ranges, channels=channel, overrides=options.overrides(change, units=units),
            likelihood=likelihood, begin=begin, end=end if end < math.inf else None, rate=rate, window=window,
            members=members, rounds=rounds, seed=seed, workers=workers, progress=told,
        )  # fmt: skip
    base = str(Path(scene).resolve()) if Path(scene).is_file() else scene
    emit(
        found.to_dict(), shown(found), json=json, folder=out,
        files={"fit.json": found.to_dict, "fitted.yaml": lambda: found.scene_text(base),
               "fit.png": lambda: fit_figure(found)},
    )  # fmt: skip
