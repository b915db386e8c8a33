# SPDX-License-Identifier: Apache-2.0
"""Commands of other packages, from the entry-point group ``drill_twin.commands``.

The entry's name is the sub-command, its value a function whose arguments typer understands
(``clearance = my_package.clearance:clearance``). Its package is imported when it is called, and for the list of all
commands, which has its help; a command of drill-twin itself starts without it. A command that cannot be loaded stays
in the list and tells why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from drill_twin.core.errors import ArgumentError

GROUP = "drill_twin.commands"
"""Entry-point group of commands in other packages."""


class CommandGroup(TyperGroup):
    """Own commands, and those of other packages, each in the panel of its distribution.

    A command of drill-twin itself cannot be replaced: one of the same name is left out, which the list of all commands
    tells in a line on stderr.
    """

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self._owner = dict.fromkeys(self.commands, "drill-twin")

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands, the own first."""
        for entry in _entries():
            self._add(entry)
        return super().list_commands(ctx)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Command of a name; None if there is none."""
        if cmd_name not in self.commands:
            if entry := next((entry for entry in _entries() if entry.name == cmd_name), None):
                self._add(entry)
            else:
                self.list_commands(ctx)  # for the names that it may have been meant to be
        return super().get_command(ctx, cmd_name)

    def _add(self, entry: EntryPoint) -> None:
        package = _package(entry)
        owner = self._owner.setdefault(entry.name, package)
        if owner != package:
            print(
                f'drill-twin: the command "{entry.name}" of the package {package} is left out: there is one of that '
                f"name in {owner}",
                file=sys.stderr,
            )
        elif entry.name not in self.commands:
            self.commands[entry.name] = _command(entry, package)


def _entries() -> list[EntryPoint]:
    return sorted(entry_points(group=GROUP), key=lambda entry: entry.name)


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else entry.value.partition(".")[0]


def _command(entry: EntryPoint, package: str) -> Any:
    """The command, or one that raises what is wrong with it."""
    try:
        return _of_function(entry.name, entry.load(), package)
    except Exception as error:  # noqa: BLE001 - another package must not stop this one
        trouble = (
            f'expected the command "{entry.name}" of the package {package} in {entry.value}, found '
            f"{type(error).__name__}: {error}; reinstall the package, or remove it"
        )
        return _of_function(entry.name, _broken(trouble), package)


def _of_function(name: str, function: Callable[..., object], package: str) -> Any:
    alone = typer.Typer(add_completion=False, rich_markup_mode="rich")
    alone.command(name, rich_help_panel=f"Of the package {package}")(function)
    return get_command(alone)


def _broken(trouble: str) -> Callable[..., object]:
    def command() -> None:
        raise ArgumentError(trouble)

    command.__doc__ = f"Cannot be loaded: {trouble}."
    return command
