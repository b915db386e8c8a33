# SPDX-License-Identifier: Apache-2.0
"""Groups of commands: an unknown one is refused with the one that was meant, `study` has those of other packages.

Commands of other packages come from the entry-point group ``drill_twin.commands``: the entry's name is the command
below `drill-twin study`, its value a function whose arguments typer understands
(``clearance = my_package.clearance:clearance``). Its package is imported when it is called, and for the list of all
studies, which has its help. A command that cannot be loaded stays in the list and tells why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from drill_twin.core.errors import ArgumentError

ENTRY_POINTS = "drill_twin.commands"
"""Entry-point group of commands in other packages."""


class CommandGroup(TyperGroup):
    """Commands, listed by `drill-twin GROUP` alone; the message on an unknown one names what was meant."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments of the group; without any, those of its help."""
        return super().parse_args(ctx, args or ["--help"])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first argument names.

        Raises:
            ArgumentError: There is none of that name.
        """
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            raise ArgumentError(f'expected a command, found "{args[0]}"{self._meant(ctx, args[0])}')
        return super().resolve_command(ctx, args)

    def _meant(self, ctx: Any, name: str) -> str:
        root = ctx.find_root()
        groups = {key: group for key, group in root.command.commands.items() if isinstance(group, CommandGroup)}
        inside = [f"{key} {name}" for key, group in groups.items() if name in group.list_commands(ctx)]
        if inside:
            return f'; it is "{root.command_path} {inside[0]}"'
        near = get_close_matches(name, self.list_commands(ctx), n=1)
        meant = f'; did you mean "{ctx.command_path} {near[0]}"?' if near else ";"
        return f"{meant} `{ctx.command_path} --help` lists all"


class StudyGroup(CommandGroup):
    """Commands of other packages, each in the panel of its distribution.

    Where two packages have one of the same name the first package has it, which the list tells in a line on stderr.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands."""
        del ctx
        return list(dict.fromkeys(entry.name for entry in _entries()))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Command of a name; None if there is none."""
        del ctx
        found = [entry for entry in _entries() if entry.name == cmd_name]
        if found and cmd_name not in self.commands:
            self.commands[cmd_name] = _command(found[0])
            for other in found[1:]:
                print(
                    f'drill-twin: the command "{cmd_name}" of the package {_package(other)} is left out: there is one '
                    f"of that name in {_package(found[0])}",
                    file=sys.stderr,
                )
        return self.commands.get(cmd_name)


def _entries() -> list[EntryPoint]:
    return sorted(entry_points(group=ENTRY_POINTS), key=lambda entry: (_package(entry), entry.name))


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else entry.value.partition(".")[0]


def _command(entry: EntryPoint) -> Any:
    """The command, or one that raises what is wrong with it."""
    try:
        return _of_function(entry, entry.load())
    except Exception as error:  # noqa: BLE001 - another package must not stop this one
        trouble = (
            f'expected the command "{entry.name}" of the package {_package(entry)} in {entry.value}, found '
            f"{type(error).__name__}: {error}; reinstall the package, or remove it"
        )
        return _of_function(entry, _broken(trouble))


def _of_function(entry: EntryPoint, function: Callable[..., object]) -> Any:
    alone = typer.Typer(add_completion=False, rich_markup_mode="rich")
    alone.command(entry.name, rich_help_panel=f"Of the package {_package(entry)}")(function)
    return get_command(alone)


def _broken(trouble: str) -> Callable[..., object]:
    def command() -> None:
        raise ArgumentError(trouble)

    command.__doc__ = f"Cannot be loaded: {trouble}."
    return command
