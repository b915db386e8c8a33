# SPDX-License-Identifier: Apache-2.0
"""Demo: rig driver, simulator, analyzer and recorder as processes on DDS, observed, ended in order, and reported.

Its exit code is 0 only if every node ended well and the bag holds every topic of the contract.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drill_twin.core.errors import BagError, RunError
from drill_twin.core.files.output import RESULTS, make_folder, new_folder
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.demo.processes import Child, processes, twin_commands

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True)
class DemoOptions:
    """Scene, duration and pace of the demo, and the folder of its result."""

    out: Path = Path("out/demo")
    """Folder of the result."""
    scene: str = "pa6_bench"
    """Scene: preset or path."""
    duration: float = 0.0
    """Simulated time [s]; 0: the scene's."""
    pace: str = "realtime"
    """Pace of the simulator: realtime, fast or lockstep."""
    replace: bool = False
    """Move an older result aside, to `<out>.old`."""


def run_demo(options: DemoOptions, stop: StopRequest) -> None:
    """Run the demo.

    Raises:
        DrillTwinError: It cannot start, or (RunError) did not end well.
    """
    from rich.console import Console

    from drill_twin.ros.deployment import own_domain
    from drill_twin.scene import load_scene

    console = Console(highlight=False)
    scene = load_scene(options.scene)
    duration = options.duration or scene.rig.duration
    if older := new_folder(options.out, replace=options.replace, results=(*RESULTS, "log")):
        console.print(f"the older result is now {older}")
    make_folder(options.out / "log")
    with own_domain((options.out / "log").absolute()) as domain:
        console.print(
            f"{scene.name}: {duration:g} s, {options.pace}; in another terminal: "
            f"[bold]ROS_DOMAIN_ID={domain} drill-twin ros doctor[/], or ros2 with ROS sourced"
        )
        environment = dict(os.environ, PYTHONUNBUFFERED="1")
        run = {"pace": options.pace, "duration": float(duration)}
        commands = twin_commands(run, {"scene": options.scene}, options.out / "bag_0")
        with processes(commands, environment, options.out / "log") as children:
            _observe(children, duration, console, stop)
    if stop:
        raise RunError(
            f"stopped before it was over; the nodes ended in order, the bag so far is {options.out / 'bag_0'}"
        )
    check_bag(options.out / "bag_0")
    draw_report(options.out, console)


# --- the processes ----------------------------------------------------------------------------------------------------


def _observe(children: Mapping[str, Child], duration: float, console: Console, stop: StopRequest) -> None:
    """Show the progress of the run until the simulator ends.

    Raises:
        RunError: A node ended with an error, or simulated time stands still.
    """
    # Imported after the children were started: DDS threads do not survive a fork.
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    from drill_twin.ros.demo.demo_observer import observed

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:5.1f} of {task.total:g} s"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("compiling and connecting", total=duration)
        with closing(observed(children, stop, progress.console.print)) as turns:
            for observer in turns:
                if stop or children["simulator"].exit_code is not None:
                    observer.drain(0.3)
                    return
                if observer.compiling:
                    progress.update(task, description=observer.compiling)
                if observer.time > 0.0:
                    factor = f" ({observer.realtime_factor:.2f} x real time)" if observer.realtime_factor else ""
                    progress.update(
                        task, completed=observer.time, description=f"{observer.motion or 'drilling'}{factor}"
                    )


# --- the result -------------------------------------------------------------------------------------------------------


def check_bag(folder: Path) -> None:
    """Check that the bag is complete and holds every topic that each run has.

    Raises:
        RunError: It is damaged, or a topic has no message.
    """
    from drill_twin.io.bag.reader import Bag
    from drill_twin.io.messages.topics import OF_EVERY_RUN

    try:
        bag = Bag(folder)
    except BagError as error:
        raise RunError(str(error)) from error
    missing = [name for name in OF_EVERY_RUN if name not in bag.topics or not bag.topics[name].count]
    if missing:
        raise RunError(f"{folder}: expected every topic of the contract, found no message on {', '.join(missing)}")
    if bag.truncated:
        raise RunError(f"{folder}: expected a whole bag, found {'; '.join(bag.damage)}")


def draw_report(out: Path, console: Console) -> None:
    """Write the report of the bag in a folder, and print its findings."""
    import json

    from drill_twin.core.table import Table
    from drill_twin.report import build_report
    from drill_twin.report.text import findings

    with console.status("drawing the report"):
        build_report(out / "bag_0", out)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    console.print(Table((), findings(summary)))
    console.print(
        f"[bold]{out / 'report.html'}[/]  (bag: {out / 'bag_0'}, figures: {out}/*.png, {out / 'summary.json'})"
    )


# --- the command ------------------------------------------------------------------------------------------------------


def options_from(arguments: Sequence[str]) -> DemoOptions:
    """The options of the command line."""
    from drill_twin.api.scenes import in_si
    from drill_twin.core.units.dimension import TIME

    defaults = DemoOptions()
    parser = argparse.ArgumentParser(
        prog="drill-twin ros demo",
        description="Run a scene as ROS 2 nodes on this machine, record it, and draw the report.",
    )
    parser.add_argument("--out", type=Path, default=defaults.out, help="new folder of the result (%(default)s)")
    parser.add_argument(
        "--scene", default=defaults.scene, help="name of an installed scene, or a scene file (%(default)s)"
    )
    parser.add_argument("--duration", default="0", help='simulated time, as "30 s" or in s; 0: the scene\'s')
    parser.add_argument(
        "--pace",
        default=defaults.pace,
        choices=("realtime", "fast", "lockstep"),
        help="pace of the simulator; lockstep: as fast as possible, and the same frames each time",
    )
    parser.add_argument("--replace", action="store_true", help="replace an older result, which is moved to OUT.old")
    given = parser.parse_args(arguments)
    return DemoOptions(given.out, given.scene, in_si("--duration", given.duration, TIME), given.pace, given.replace)


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the demo with these command-line arguments."""
    run_demo(options_from(arguments), stop)
