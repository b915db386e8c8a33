# SPDX-License-Identifier: Apache-2.0
"""Arguments and options of several commands."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from drill_twin.core.errors import ArgumentError
from drill_twin.core.numerals import whole_number


def time_option(name: str, text: str, least: float = -math.inf, most: float = math.inf, *, shown: bool = True) -> Any:
    """Option of a time in s, which takes text with a unit or a bare number.

    Args:
        name: Name of the option, such as `--from`.
        text: Help of the option, without a period.
        least: Least time [s].
        most: Largest time [s].
        shown: Show the default.
    """

    def seconds(given: str | float) -> float:
        from drill_twin.api.scenes import in_si
        from drill_twin.core.units.dimension import TIME

        value = given if isinstance(given, float) else in_si(name, given, TIME)
        if not least <= value <= most:
            raise ArgumentError(f"{name}: expected a time from {least:g} to {most:g} s, found {given}")
        return value

    text += ', as "5 s"; a bare number is in s.'
    return typer.Option(name, metavar="TIME", parser=seconds, help=text, show_default=shown)


SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Name of an installed scene (`drill-twin scene list`), or a scene file.")
]
BagArgument = Annotated[
    Path,
    typer.Argument(
        metavar="BAG", help="Folder of a bag, a .mcap or .db3 file, or the folder of a run with bag_0 in it."
    ),
]
RecordedArgument = Annotated[
    Path, typer.Argument(metavar="BAG", help="Bag, folder of a run, or record of a rig (CSV, MAT, LAS, WITSML).")
]
SetOption = Annotated[
    list[str],
    typer.Option(
        "--set", metavar="KEY=VALUE", help='Change the scene, as "hole.radius=80 mm" or "effects.bow=off"; repeatable.'
    ),
]
WithoutOption = Annotated[
    list[str], typer.Option("--without", metavar="EFFECT", help="Leave this effect of the scene out; repeatable.")
]
WeightOption = Annotated[
    str, typer.Option("--wob", metavar="FORCE", help='Weight on bit, as "40 N"; a bare number is in N.')
]
RpmOption = Annotated[
    str,
    typer.Option("--rpm", metavar="SPEED", help='Speed of the top drive, as "2 rev/s"; a bare number is in rev/min.'),
]
UnitsOption = Annotated[
    Literal["", "field", "si", "lab"],
    typer.Option(
        "--units",
        metavar="field|si|lab",
        help="Units of tables, figures and pages; JSON and CSV are in SI.",
        show_default="the scene's",
    ),
]
DurationOption = Annotated[
    str, typer.Option("--duration", metavar="TIME", help='Simulated time, as "30 s"; a bare number is in s.')
]
FittedArgument = Annotated[
    Path, typer.Argument(metavar="RECORD", help="A CSV, MAT, LAS or WITSML file, or a bag of a twin.")
]
FittedOption = Annotated[str, typer.Option("--scene", metavar="SCENE", help="Scene, by name or file.")]
FreeOption = Annotated[
    list[str],
    typer.Option(
        "--free",
        metavar="KEY=LO..HI",
        help='Number to find and its range, as "wall_friction.coefficient=0.05..0.5"; for `estimate` also '
        '"load_factor=0.8..1.2", a factor on the load; repeatable.',
    ),
]
ChannelOption = Annotated[
    list[str],
    typer.Option(
        "--channel",
        metavar="NAME=COLUMN:UNIT",
        help='Channel and its column, as "bit_speed=Bit_Speed:rpm"; for a bag NAME alone; set-points are '
        "weight_on_bit and rotation; repeatable.",
    ),
]
ColumnOption = Annotated[
    list[str],
    typer.Option(
        "--channel",
        metavar="NAME=COLUMN:UNIT",
        help='Column of a record for a channel, as "weight_on_bit=WOB:klbf"; for dates the form, as '
        '"time=Time:DD/MM/YYYY"; repeatable. All commands read such pairs from RECORD.yaml beside the record.',
    ),
]
NullOption = Annotated[
    list[str],
    typer.Option("--null", metavar="NUMBER", help="Number that stands for a missing value in a record; repeatable."),
]
SeedOption = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the draws.")]
SceneOption = Annotated[
    str, typer.Option("--scene", metavar="SCENE", help="Scene of the record, or of a bag that contains none.")
]
NamespaceOption = Annotated[
    str, typer.Option("--namespace", metavar="NS", help="Namespace of the twin, as /rig2, where a bag holds several.")
]
FromOption = Annotated[float, time_option("--from", "Leave out samples before this time", shown=False)]
ToOption = Annotated[float, time_option("--to", "Leave out samples after this time", shown=False)]
RunOption = Annotated[
    int,
    typer.Option(
        "--run", metavar="N", help="Number of the run, in a bag with several.", min=0, show_default="the last"
    ),
]
RemapOption = Annotated[
    list[str],
    typer.Option(
        "--remap",
        metavar="THEIRS=OURS",
        help='Read a topic under our name, as "/camera/marks=/marks/state"; repeatable.',
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON on stdout, and nothing else.")]
ReplaceOption = Annotated[
    bool, typer.Option("--replace", help="Replace an older result, which is moved to DIR.old if it is a folder.")
]


def _cores_for_zero(count: int) -> int:
    from drill_twin.studies.pool import cores

    return count or cores()


WorkersOption = Annotated[
    int,
    typer.Option("--workers", metavar="N", min=0, help="Runs at a time; 0: one per core.", callback=_cores_for_zero),
]


AllOption = Annotated[bool, typer.Option("--all", help="Show all that was found, not the verdict and five rows alone.")]


def folder_option(text: str, default: str | None = None) -> Any:
    """Option `--out DIR`.

    Args:
        text: Help of the option.
        default: Folder that is taken without it, in words; None: no files are written.
    """
    return typer.Option("--out", metavar="DIR", help=text, show_default=default or True)


def overrides(pairs: list[str], **shorthands: str) -> dict[str, str]:
    """Overrides of a scene from the options.

    Raises:
        ArgumentError: A pair is not KEY=VALUE.
    """
    given = {key: value for key, value in shorthands.items() if value}
    return given | pairs_of("--set", pairs, "KEY=VALUE", "hole.radius=80 mm")


def choices(channels: list[str], nulls: list[str]) -> tuple[str, ...]:
    """Columns and null values of a record from the options."""
    return (*channels, *(f"null_value={null}" for null in nulls))


def ranges_of(option: str, pairs: list[str]) -> dict[str, str]:
    """Ranges by key of an option such as `--free`.

    Raises:
        ArgumentError: A pair is not KEY=LO..HI.
    """
    return pairs_of(option, pairs, "KEY=LO..HI", "wall_friction.coefficient=0.1..0.3")


def pairs_of(option: str, pairs: list[str], form: str, example: str) -> dict[str, str]:
    """Values by key of the pairs of an option.

    Raises:
        ArgumentError: A pair has another form, or a key occurs twice.
    """
    found: dict[str, str] = {}
    for pair in pairs:
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not (equals and key and value):
            raise ArgumentError(f'{option}: expected {form} such as "{example}", found "{pair}"')
        if key in found:
            raise ArgumentError(f"{option}: expected each key once, found {key} twice; leave one out")
        found[key] = value
    return found


def meshes(text: str, example: str) -> list[int]:
    """Numbers of elements of an option such as "8,12,16".

    Raises:
        ArgumentError: The text lists no such numbers.
    """
    found = [count for word in text.split(",") if (count := whole_number(word.strip()) or 0) > 1]
    if len(found) <= text.count(","):
        raise ArgumentError(f'--elements: expected numbers such as "{example}", found "{text}"')
    return found
