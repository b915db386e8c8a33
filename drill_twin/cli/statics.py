# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin statics`: hookload, torque, loads along the string and margins of each operation."""

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress
from drill_twin.core.errors import SceneError
from drill_twin.core.files.output import make_folder


def statics(
    scene: options.SceneArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    without: options.WithoutOption = [],  # noqa: B006
    trip_speed: Annotated[
        str, typer.Option("--trip-speed", metavar="SPEED", help='Speed of tripping, as "0.3 m/s".')
    ] = "0.3 m/s",
    feed: Annotated[
        str, typer.Option("--rop", metavar="SPEED", help='Rate of penetration when sliding and drilling, as "18 m/h".')
    ] = "18 m/h",
    friction: Annotated[
        str,
        typer.Option(
            "--friction",
            metavar="LO..HI:N",
            help='Loads over the depth of the bit for these coefficients, as "0.15..0.35:5".',
        ),
    ] = "",
    measured: Annotated[
        Path | None,
        typer.Option(
            "--measured",
            metavar="FILE",
            help="With --friction: record with columns of the depth and of trip out, trip in, off bottom or torque.",
        ),
    ] = None,
    units: options.UnitsOption = "",
    out: Annotated[
        Path | None, options.folder_option("Write statics.json, statics.csv and statics.png to this folder.")
    ] = None,
    json: options.JsonOption = False,
) -> None:
    """Compute torque, drag and buckling without a run: tripping, rotating off bottom, sliding, drilling.

    The string lies in balance in its hole, with friction against the motion of each operation; the soft string stands
    beside it. With --friction the command computes hookload and torque of the soft string over the depth of its bit
    instead, with measured points (the broomstick plot), and writes over_depth.json and over_depth.png.
    """
    from drill_twin.api.torque_drag import statics as computed
    from drill_twin.studies.answers import shown_statics
    from drill_twin.studies.statics import depth_table, statics_data, tracks

    speeds = {option: _speed(option, text) for option, text in (("--trip-speed", trip_speed), ("--rop", feed))}
    if measured is not None and not friction:
        raise SceneError("--measured: expected --friction beside it, found none; as --friction 0.15..0.35:5")
    if out is not None:
        make_folder(out)
    changes = options.overrides(change, wob=wob, rpm=rpm, units=units)
    if friction:
        _over_depth(scene, changes, without, friction, measured, out, json=json)
        return
    with shown_progress("computing"):
        found = computed(scene, changes, without=without, trip_speed=speeds["--trip-speed"], feed=speeds["--rop"])
    data = statics_data(found)
    emit(
        data, shown_statics(found), json=json, folder=out,
        files={"statics.json": data, "statics.csv": lambda: depth_table(found).csv(),
               "statics.png": lambda: tracks(found)},
    )  # fmt: skip


def _over_depth(
    scene: str, changes: dict[str, str], without: list[str], friction: str, measured: Path | None, out: Path | None,
    *, json: bool,
) -> None:  # fmt: skip
    from drill_twin.api.torque_drag import statics_over_depth
    from drill_twin.studies.over_depth import broomstick, coefficients, fits_of, over_depth_data, read_measured, shown

    wanted, points = coefficients(friction), read_measured(measured) if measured else {}
    with shown_progress("computing"):
        found = statics_over_depth(scene, wanted, changes, without=without)
        fits = fits_of(found, points)
    data = over_depth_data(found, points, fits)
    emit(
        data, shown(found, points, fits), json=json, folder=out,
        files={"over_depth.json": data, "over_depth.png": lambda: broomstick(found, points, fits)},
    )  # fmt: skip


def _speed(option: str, text: str) -> float:
    from drill_twin.api.scenes import in_si
    from drill_twin.core.units.dimension import SPEED

    if (value := in_si(option, text, SPEED)) <= 0.0:
        raise SceneError(f'{option}: expected a speed above 0, found "{text}"; operations have a direction')
    return value
