# SPDX-License-Identifier: Apache-2.0
"""Commands of other packages, from the entry-point group ``drill_twin.commands``.

The entry's name is the sub-command, its value a function whose arguments typer understands
(``clearance = my_package.clearance:clearance``). A command that cannot be loaded stays in the list and tells why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points

import typer
from typer.main import get_command

from drill_twin.core.errors import ArgumentError

GROUP = "drill_twin.commands"
"""Entry-point group of commands in other packages."""


def add_commands(app: typer.Typer) -> None:
    """Add the commands of other packages, each in the panel of its distribution.

    A command of drill-twin itself cannot be replaced: one of the same name is left out, with a line on stderr.
    """
    taken = {_name(command.name, command.callback): "drill-twin" for command in app.registered_commands}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        package = _package(entry)
        if entry.name in taken:
            print(
                f'drill-twin: the command "{entry.name}" of the package {package} is left out: there is one of that '
                f"name in {taken[entry.name]}",
                file=sys.stderr,
            )
            continue
        taken[entry.name] = package
        app.command(entry.name, rich_help_panel=f"Of the package {package}")(_function(entry, package))


def _name(name: str | None, function: Callable[..., object] | None) -> str:
    return name or getattr(function, "__name__", "").replace("_", "-")


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else entry.value.partition(".")[0]


def _function(entry: EntryPoint, package: str) -> Callable[..., object]:
    """Function of the command, or one that raises what is wrong with it."""
    try:
        function: Callable[..., object] = entry.load()
        alone = typer.Typer()
        alone.command()(function)
        get_command(alone)  # its arguments are ones that typer understands
    except Exception as error:  # noqa: BLE001 - another package must not stop this one
        return _broken(
            f'expected the command "{entry.name}" of the package {package} in {entry.value}, found '
            f"{type(error).__name__}: {error}; reinstall the package, or remove it"
        )
    return function


def _broken(trouble: str) -> Callable[..., object]:
    def command() -> None:
        raise ArgumentError(trouble)

    command.__doc__ = f"Cannot be loaded: {trouble}."
    return command
