# SPDX-License-Identifier: Apache-2.0
"""The commands; each imports its modules when it is called, so that --help is fast.

Commands of other packages come from the entry-point group ``drill_twin.commands``: the entry's name is the sub-command,
its value a function whose arguments typer understands (``clearance = my_package.clearance:clearance``). Its package is
imported when it is called, and for the list of all commands, which has its help. A command that cannot be loaded stays
in the list and tells why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from drill_twin.cli.analyze import analyze, report
from drill_twin.cli.compare import compare
from drill_twin.cli.cost import cost
from drill_twin.cli.effects import effects
from drill_twin.cli.estimate import estimate
from drill_twin.cli.export import drillbotics, export
from drill_twin.cli.fit import fit
from drill_twin.cli.modes import modes
from drill_twin.cli.operating_map import operating_map
from drill_twin.cli.rerun import rerun
from drill_twin.cli.ros import demo, doctor, gateway_keys, load, node, replay, topics
from drill_twin.cli.run import run
from drill_twin.cli.scenes import check, new, scenes, schema
from drill_twin.cli.statics import statics
from drill_twin.cli.watch import watch
from drill_twin.cli.whirl_states import whirl_states
from drill_twin.core import __version__
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


app = typer.Typer(
    cls=CommandGroup,
    help="A digital twin of a drillstring: simulate a scene, analyse a bag, draw a report. Only [bold]node[/], "
    "[bold]demo[/], [bold]replay[/], [bold]load[/], and [bold]watch[/] without a bag, need ROS 2 (rclpy).",
    epilog='For example: [bold]drill-twin run pa6_bench --wob "40 N" --rps 2 --duration 30 --out out/first --report[/]',
    rich_markup_mode="rich",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"drill-twin {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    del version


_RUN, _STUDY, _SCENE, _ROS = "Simulate and analyse", "Studies", "Scenes", "ROS"
app.command(rich_help_panel=_RUN)(run)
app.command(rich_help_panel=_RUN)(analyze)
app.command(rich_help_panel=_RUN)(report)
app.command(rich_help_panel=_RUN)(rerun)
app.command(rich_help_panel=_RUN)(export)
app.command(rich_help_panel=_RUN)(drillbotics)
app.command(rich_help_panel=_RUN)(fit)
app.command(rich_help_panel=_RUN)(estimate)
app.command(rich_help_panel=_RUN)(watch)
app.command(rich_help_panel=_RUN)(statics)
app.command(rich_help_panel=_RUN)(modes)
app.command(rich_help_panel=_RUN)(whirl_states)
app.command("map", rich_help_panel=_RUN)(operating_map)
app.command(rich_help_panel=_RUN)(compare)
app.command(rich_help_panel=_STUDY)(cost)
app.command(rich_help_panel=_STUDY)(effects)
app.command(rich_help_panel=_SCENE)(scenes)
app.command(rich_help_panel=_SCENE)(new)
app.command(rich_help_panel=_SCENE)(check)
app.command(rich_help_panel=_SCENE)(schema)
app.command(
    rich_help_panel=_ROS,
    context_settings={
        "allow_extra_args": True,
        "allow_interspersed_args": False,
        "ignore_unknown_options": True,
    },
)(node)
app.command(
    rich_help_panel=_ROS,
    add_help_option=False,
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []},
)(demo)
app.command(rich_help_panel=_ROS)(replay)
app.command(rich_help_panel=_ROS)(load)
app.command(rich_help_panel=_ROS)(gateway_keys)
app.command(rich_help_panel=_ROS)(doctor)
app.command(rich_help_panel=_ROS)(topics)
