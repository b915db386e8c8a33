# SPDX-License-Identifier: Apache-2.0
"""Arguments and options of several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from drill_twin.core.errors import SceneError

SceneArgument = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="Installed scene (see `drill-twin scene list`), or a scene file."),
]
BagArgument = Annotated[
    Path,
    typer.Argument(
        metavar="BAG", help="Folder of a bag, a .mcap or .db3 file, or the folder of a run with bag_0 in it."
    ),
]
RecordedArgument = Annotated[
    Path,
    typer.Argument(metavar="BAG", help="A bag, or the folder of a run; or a record of a rig (CSV, MAT, LAS, WITSML)."),
]
SetOption = Annotated[
    list[str],
    typer.Option(
        "--set", metavar="KEY=VALUE", help='Change the scene, as "hole.radius=80 mm" or "effects.bow=off"; repeatable.'
    ),
]
WithoutOption = Annotated[
    list[str], typer.Option("--without", metavar="EFFECT", help="Leave an effect of the scene out; repeatable.")
]
WeightOption = Annotated[
    str, typer.Option("--wob", metavar="FORCE", help='Weight on bit, as "40 N"; a bare number is in N.')
]
TurnOption = Annotated[
    str, typer.Option("--rps", metavar="SPEED", help='Top-drive speed, as "50 rpm"; a bare number is in rev/s.')
]
RpmOption = Annotated[
    str, typer.Option("--rpm", metavar="SPEED", help="The same; a bare number is in revolutions per minute.")
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
SceneOption = Annotated[str, typer.Option("--scene", metavar="SCENE", help="Scene of a bag that contains none.")]
NamespaceOption = Annotated[
    str, typer.Option("--namespace", metavar="NS", help="Namespace of the twin, as /rig2, where a bag holds several.")
]
FromOption = Annotated[
    float, typer.Option("--from", metavar="SECONDS", help="Leave out earlier samples.", show_default=False)
]
ToOption = Annotated[
    float, typer.Option("--to", metavar="SECONDS", help="Leave out later samples.", show_default=False)
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else, on stdout.")]
ReplaceOption = Annotated[bool, typer.Option("--replace", help="Replace an existing result of drill-twin.")]


def _cores_for_zero(count: int) -> int:
    from drill_twin.studies.pool import cores

    return count or cores()


WorkersOption = Annotated[
    int,
    typer.Option("--workers", metavar="N", min=0, help="Processes at a time; 0: one a core.", callback=_cores_for_zero),
]


def folder_option(text: str, default: str | None = None) -> Any:
    """Option `--out DIR`.

    Args:
        text: Its help.
        default: Folder that is taken without it, in words; None: no files are written.
    """
    return typer.Option("--out", metavar="DIR", help=text, show_default=default or True)


def overrides(pairs: list[str], **shorthands: str) -> dict[str, str]:
    """Overrides of a scene from the options.

    Raises:
        SceneError: A pair is not KEY=VALUE.
    """
    changes = {key: value for key, value in shorthands.items() if value}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not (equals and key.strip() and value.strip()):
            raise SceneError(f'--set: expected KEY=VALUE such as "hole.radius=80 mm", found "{pair}"')
        changes[key.strip()] = value.strip()
    return changes


def meshes(text: str, example: str) -> list[int]:
    """Numbers of elements of an option such as "8,12,16".

    Raises:
        SceneError: It is none.
    """
    words = text.split(",")
    if not all(word.strip().isdigit() and int(word) > 1 for word in words):
        raise SceneError(f'--elements: expected numbers such as "{example}", found "{text}"')
    return [int(word) for word in words]
