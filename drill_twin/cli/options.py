# SPDX-License-Identifier: Apache-2.0
"""Arguments and options of several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.errors import SceneError

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="An installed scene by name (see `drill-twin scenes`), or a scene file.")
]
BagArgument = Annotated[
    Path,
    typer.Argument(
        metavar="BAG", help="Folder of a bag, a .mcap or .db3 file, or the folder of a run with bag_0 in it."
    ),
]
SetOption = Annotated[
    list[str],
    typer.Option(
        "--set", metavar="KEY=VALUE", help='Change the scene, as "hole.radius=80 mm" or "effects.bow=off"; repeatable.'
    ),
]
SceneOption = Annotated[str, typer.Option("--scene", metavar="SCENE", help="Scene of a bag that contains none.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else, on stdout.")]
ReplaceOption = Annotated[bool, typer.Option("--replace", help="Replace an existing result of drill-twin.")]


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
