# SPDX-License-Identifier: Apache-2.0
"""The commands; each imports its modules when it is called, so that --help is fast."""

from __future__ import annotations

from typing import Annotated

import typer

from drill_twin.cli.added import CommandGroup
from drill_twin.cli.bags.analyze import analyze, report
from drill_twin.cli.bags.drillbotics import drillbotics
from drill_twin.cli.bags.export import export
from drill_twin.cli.bags.rerun import rerun
from drill_twin.cli.bags.watch import watch
from drill_twin.cli.ros.doctor import doctor
from drill_twin.cli.ros.gateway_keys import gateway_keys
from drill_twin.cli.ros.nodes import demo, load, node, replay, topics
from drill_twin.cli.runs.estimate import estimate
from drill_twin.cli.runs.fit import fit
from drill_twin.cli.runs.operating_map import operating_map
from drill_twin.cli.runs.run import run
from drill_twin.cli.scenes.new import new
from drill_twin.cli.scenes.scenes import check, scenes, schema
from drill_twin.cli.steady_states.modes import modes
from drill_twin.cli.steady_states.statics import statics
from drill_twin.cli.steady_states.whirl_states import whirl_states
from drill_twin.cli.studies.compare import compare
from drill_twin.cli.studies.cost import cost
from drill_twin.cli.studies.effects import effects
from drill_twin.core.version import __version__

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
