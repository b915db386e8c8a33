# SPDX-License-Identifier: Apache-2.0
"""The tree of commands. A command imports its modules when it is called, so that --help is fast."""

from collections.abc import Callable, Iterator
from typing import Annotated, Any

import typer
from typer.main import get_command

from drill_twin.cli import ros
from drill_twin.cli.analyze import analyze, export, report
from drill_twin.cli.compare import compare, rerun
from drill_twin.cli.cost import cost, effects
from drill_twin.cli.groups import ANY_ARGUMENTS, CommandGroup, StudyGroup
from drill_twin.cli.modes import modes
from drill_twin.cli.run import run
from drill_twin.cli.scene import check, new, scenes, schema
from drill_twin.cli.statics import statics
from drill_twin.cli.whirl import whirl
from drill_twin.core import __version__

app = typer.Typer(
    name="drill-twin",
    cls=CommandGroup,
    help="A digital twin of a drillstring: simulate a scene, analyse a bag, draw a report. Only [bold]ros[/], "
    "[bold]replay[/] and [bold]watch live[/] need ROS 2 (rclpy).",
    epilog='For example: [bold]drill-twin run pa6_bench --wob "40 N" --rpm 120 --duration 30 --report[/]',
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


def _add(group: typer.Typer, commands: dict[str, Callable[..., object]], panel: str | None = None) -> None:
    for name, function in commands.items():
        group.command(name, rich_help_panel=panel)(function)


_add(
    app,
    {"run": run, "rerun": rerun, "analyze": analyze, "report": report, "export": export, "replay": ros.replay},
    "Runs and records",
)  # fmt: skip
_add(
    app,
    {"statics": statics, "modes": modes, "whirl": whirl, "compare": compare, "cost": cost, "effects": effects},
    "Questions about a string",
)  # fmt: skip

_scene = typer.Typer(cls=CommandGroup, help="List, make and check scenes.")
_add(_scene, {"list": scenes, "new": new, "check": check, "schema": schema})

_nodes = typer.Typer(cls=CommandGroup, help="Run and examine the ROS 2 nodes; demo and node need rclpy.")
_nodes.command(add_help_option=False, context_settings={**ANY_ARGUMENTS, "help_option_names": []})(ros.demo)
_nodes.command(context_settings={**ANY_ARGUMENTS, "allow_interspersed_args": False})(ros.node)
_add(_nodes, {"doctor": ros.doctor, "topics": ros.topics})

_study = typer.Typer(cls=StudyGroup, help="Commands of other packages: of drill_twin_evidence, and of yours.")
for _name, _group in (("scene", _scene), ("ros", _nodes), ("study", _study)):
    app.add_typer(_group, name=_name, rich_help_panel="Groups of commands")


def commands(group: Any = None, name: str = "drill-twin") -> Iterator[tuple[str, Any]]:
    """Whole name and command of each leaf of the tree, in the order of the help."""
    group = group or get_command(app)
    for key in group.list_commands(None):
        if isinstance(command := group.get_command(None, key), CommandGroup):
            yield from commands(command, f"{name} {key}")
        else:
            yield f"{name} {key}", command
