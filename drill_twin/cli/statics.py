# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin statics`: hookload, torque, loads along the string and margins of each operation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress
from drill_twin.core.errors import SceneError
from drill_twin.core.files.output import make_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.dynamics.torque_drag.analysis import Statics

SMALL = 1.0
"""Force of the wall below which a contact carries nothing [N], chosen."""
SHAPES = ("straight", "sinusoidal", "sinusoidal, helix", "helix")
"""Words for `BucklingState` in the columns of the table."""


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
        data, _shown(found), json=json, folder=out,
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
        raise SceneError(f'{option}: expected a speed above 0, found "{text}"; the operation says the direction')
    return value


def _shown(found: Statics) -> Iterator[Table | str]:
    from drill_twin.studies.statics import PART, loads_table, parts_of

    operations, u = found.operations, found.scene.unit_system
    yield loads_table(found)
    yield from found.notes.values()
    yield Table(
        ("operation", "sinusoidal", "helix", "lock-up", "yield", "make-up", "stress", "shape"),
        [
            (
                loads.operation.name, *(_ratio(margin) for margin in loads.margins),
                _ratio(loads.lock_up / loads.operation.weight_on_bit if loads.operation.is_on_bottom else math.nan),
                _ratio(loads.yield_margin), _ratio(loads.make_up_margin),
                f"{u.show(float(loads.along.stress.max()), 'stress'):.4g}", SHAPES[loads.worst_state],
            )
            for loads in operations
        ],
        title=f"margins: limit over load where least, below 1 it is passed; largest stress in {u.stress}",
        right=range(1, 8),
    )  # fmt: skip
    if bent := [loads for loads in operations if loads.worst_state and loads.along.side_force.max() < 1e-6]:
        yield (
            f"{', '.join(loads.operation.name for loads in bent)}: past a buckling load, but in balance on the axis: "
            "hookload, stress and yield hold for straight pipe, without its bend and the friction of a helix"
        )
    yield Table(
        ("operation", *(contact.name for contact in operations[0].contacts)),
        [
            (
                loads.operation.name,
                *(f"{u.show(c.force, 'force'):.3g}, {math.degrees(c.tilt):.2f}" for c in loads.contacts),
            )
            for loads in operations
        ],
        title=f"force of the wall on bit and stabilisers in {u.force}, tilt against the hole in deg",
        right=range(1, 1 + len(operations[0].contacts)),
    )  # fmt: skip
    bits = [(loads.operation.name, loads.contacts[0]) for loads in operations]
    if math.isfinite(bits[0][1].build):
        yield Table(
            ("operation", "build +, drop -", "right +, left -", "tilt, up +"),
            [
                (name, *(f"{round(float(value), 3) + 0.0:+.3f}" for value in (
                    u.show(bit.build, "force"), u.show(bit.walk, "force"), math.degrees(bit.lift))))
                for name, bit in bits
            ],
            title=f"force of the bit on the hole in {u.force}, tilt in deg; what it cuts sideways is not computed",
            right=range(1, 4),
        )  # fmt: skip
    elif len(operations[0].contacts) > 1 and max(one.force for loads in operations for one in loads.contacts) < SMALL:
        yield (
            "forces of bit and stabilisers are 0, as the hole is vertical and nothing presses them to the wall; a "
            "survey with the inclination of the real hole, be it 0.5 deg, shows them"
        )
    last, kinds = operations[-1], [kind for _, _, kind in PART]
    yield Table(
        ("part", *(word for word, _, _ in PART)),
        [
            (name, *(f"{u.show(value, kind) if kind else 100.0 * value:.4g}"
                     for value, kind in zip(values.tolist(), kinds, strict=True)))
            for name, values in parts_of(found.scene, last)
        ],
        title=f"{last.operation.name}: lower end of each part in {u.length}, tension in {u.force} and torque in "
        f"{u.torque} at its upper end, side force on all of it in {u.force}, share of it on the wall in %, largest "
        f"moment in {u.torque} and stress in {u.stress}",
        right=range(1, 8),
    )  # fmt: skip


def _ratio(margin: float) -> str:
    if not math.isfinite(margin):
        return "-"
    return f"{margin:.3g}" if margin < 1000.0 else "> 1000"
