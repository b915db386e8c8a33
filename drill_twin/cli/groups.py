# SPDX-License-Identifier: Apache-2.0
"""Groups of commands: an unknown command is refused with the nearest known name; commands of other packages.

Commands of other packages come from the entry-point group ``drill_twin.commands``: the entry's name is the command
below `drill-twin study`, its value a function whose arguments typer understands
(``clearance = my_package.clearance:clearance``). Its package is imported when the command is called, and for a list of
commands, which has its help. A command that cannot be loaded stays in the list and tells why. A name of
two words (``ros load``) stands in that group, and commands of the companions (`drill_twin.core.companions`) stand
beside the commands of the core, installed or not.
"""

import sys
from collections.abc import Callable
from difflib import get_close_matches
from importlib.metadata import EntryPoint
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from drill_twin.core.companions import COMPANIONS, entries, is_installed, not_installed, package_of
from drill_twin.core.errors import ArgumentError

ENTRY_POINTS = "drill_twin.commands"
"""Entry-point group of commands in other packages."""
ANY_ARGUMENTS = {"allow_extra_args": True, "ignore_unknown_options": True}
"""Settings of a command that hands its arguments on."""
_OF_COMPANIONS = {
    command: (companion.name, panel) for companion in COMPANIONS for command, panel in companion.commands.items()
}
"""Package and panel of each command of a companion, by its whole name."""


class CommandGroup(TyperGroup):
    """Commands, listed by `drill-twin GROUP` alone; the message on an unknown command names the nearest."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands: the core's, then other packages'."""
        return list(dict.fromkeys([*super().list_commands(ctx), *self._of_others()]))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Command of a name; None if there is none."""
        if cmd_name not in self.commands and cmd_name in (whole := self._of_others()):
            self.commands[cmd_name] = _of_another(whole[cmd_name])
        return super().get_command(ctx, cmd_name)

    def _of_others(self) -> dict[str, str]:
        """Whole names of the commands of other packages in this group, by their last word."""
        place = "" if self.name == "drill-twin" else f"{self.name} "
        added = [entry.name for entry in entries(ENTRY_POINTS)] if place else []
        rest = {whole.removeprefix(place): whole for whole in (*_OF_COMPANIONS, *added) if whole.startswith(place)}
        return {name: whole for name, whole in rest.items() if " " not in name}

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments of the group; without any, `--help`."""
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
        if inside := [f"{key} {name}" for key, group in groups.items() if name in group.list_commands(ctx)]:
            return f'; it is "{root.command_path} {inside[0]}"'
        near = get_close_matches(name, self.list_commands(ctx), n=1)
        meant = f'; did you mean "{ctx.command_path} {near[0]}"?' if near else ";"
        return f"{meant} `{ctx.command_path} --help` lists all"


class StudyGroup(CommandGroup):
    """Commands of other packages, each in the panel of its distribution.

    Where two packages have a command of the same name, the first package's is taken; a line on stderr says so.
    """

    def _of_others(self) -> dict[str, str]:
        names = (entry.name for entry in entries(ENTRY_POINTS))
        return {name: name for name in names if name not in _OF_COMPANIONS and " " not in name}


def _of_another(whole: str) -> Any:
    """Command of another package, or a command that refuses with the name of the companion to install."""
    package, panel = _OF_COMPANIONS.get(whole, ("", ""))
    name, found = whole.rpartition(" ")[2], [entry for entry in entries(ENTRY_POINTS) if entry.name == whole]
    if not found:
        error = not_installed(f"`drill-twin {whole}`", package)
        there = f"Not registered; install {package} again."
        return _refused(
            name, panel, error, there if is_installed(package) else f"Not installed; it is in the package {package}."
        )
    first, *others = found
    for other in others:
        print(
            f'drill-twin: the command "{whole}" of the package {package_of(other)} is left out: there is '
            f"a command of that name in {package_of(first)}",
            file=sys.stderr,
        )
    own = not package and name == whole
    return _command(first, name, f"Of the package {package_of(first)}" if own else panel)


def _refused(name: str, panel: str, error: ArgumentError, help_text: str) -> Any:
    """Command that takes any arguments and raises an error."""

    def command(context: typer.Context) -> None:
        del context
        raise error

    command.__doc__ = help_text
    return _of_function(name, panel, command, ANY_ARGUMENTS)


def _command(entry: EntryPoint, name: str, panel: str) -> Any:
    """The command of an entry point, or a command that raises why the entry point cannot be loaded."""
    try:
        return _of_function(name, panel, entry.load())
    except Exception as error:  # noqa: BLE001 - another package must not stop this one
        trouble = (
            f'expected the command "{entry.name}" of the package {package_of(entry)} in {entry.value}, found '
            f"{type(error).__name__}: {error}; reinstall the package, or remove it"
        )
        return _refused(name, panel, ArgumentError(trouble), f"Cannot be loaded: {trouble}.")


def _of_function(name: str, panel: str, function: Callable[..., object], settings: dict[str, Any] | None = None) -> Any:
    alone = typer.Typer(add_completion=False, rich_markup_mode="rich")
    alone.command(name, rich_help_panel=panel or None, context_settings=settings or {})(function)
    return get_command(alone)
