# SPDX-License-Identifier: Apache-2.0
"""Demo: rig driver, simulator, analyzer and recorder as processes on DDS, observed, ended in order, and reported.

Its exit code is 0 only if every node ended well and the bag holds every topic of the contract.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drill_twin.core.errors import RunError
from drill_twin.core.files.output import RESULTS, make_folder, new_folder
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.demo.processes import Child, processes
from drill_twin.ros.demo.result import check_bag, draw_report
from drill_twin.ros.demo.stall_detector import STARTING_TIME, StallDetector

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

    from drill_twin.ros.deployment.discovery import DomainClaim, domain_of_environment, prepare
    from drill_twin.scene import load_scene

    console = Console(highlight=False)
    scene = load_scene(options.scene)
    duration = options.duration or scene.rig.duration
    if older := new_folder(options.out, replace=options.replace, results=(*RESULTS, "log")):
        console.print(f"the older result is now {older}")
    make_folder(options.out / "log")
    claim = DomainClaim(domain_of_environment())
    os.environ["ROS_DOMAIN_ID"] = str(claim.domain)
    os.environ["ROS_LOG_DIR"] = str((options.out / "log").absolute())
    prepare()
    try:
        console.print(
            f"{scene.name}: {duration:g} s, {options.pace}; in another terminal, with ROS sourced: "
            f"[bold]ROS_DOMAIN_ID={claim.domain} ros2 topic list[/]"
        )
        _run_nodes(options, duration, console, stop)
    finally:
        claim.release()
    if stop:
        raise RunError(
            f"stopped before it was over; the nodes ended in order, the bag so far is {options.out / 'bag_0'}"
        )
    check_bag(options.out / "bag_0")
    draw_report(options.out, console)


# --- the processes ----------------------------------------------------------------------------------------------------


def _commands(options: DemoOptions, duration: float) -> dict[str, Mapping[str, object]]:
    """Nodes and their parameters, in the order in which they are ended: subscribers after publishers."""
    return {
        "simulator": {"scene": options.scene, "pace": options.pace, "duration": float(duration)},
        "rig_driver": {
            "scene": options.scene,
            "wait_for": "simulator analyzer recorder",
            "wait_timeout": STARTING_TIME,
        },
        "analyzer": {},
        "recorder": {"bag": str((options.out / "bag_0").absolute())},
    }


def _run_nodes(options: DemoOptions, duration: float, console: Console, stop: StopRequest) -> None:
    """Run the nodes until the simulator is done."""
    environment = dict(os.environ, PYTHONUNBUFFERED="1")
    with processes(_commands(options, duration), environment, options.out / "log") as children:
        _observe(children, duration, console, stop)


def _observe(children: Mapping[str, Child], duration: float, console: Console, stop: StopRequest) -> None:
    """Show the progress of the run until the simulator ends.

    Raises:
        RunError: A node ended with an error, or simulated time stands still.
    """
    # Imported after the children were started: DDS threads do not survive a fork.
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    from drill_twin.ros.core.node_main import init_context
    from drill_twin.ros.demo.demo_observer import DemoObserver

    context = init_context([], stop)
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:5.1f} of {task.total:g} s"),
        TimeElapsedColumn(),
    )
    try:
        with Progress(*columns, console=console, transient=True) as progress:
            observer = DemoObserver(context, progress.console.print)
            task = progress.add_task("compiling and connecting", total=duration)
            stall_detector = StallDetector()
            while not stop and children["simulator"].exit_code is None:
                observer.spin_once(0.1)
                for child in children.values():
                    child.check_alive()
                stall_detector.check(observer.time, compiling=bool(observer.compiling))
                if observer.compiling:
                    progress.update(task, description=observer.compiling)
                if observer.time > 0.0:
                    factor = f" ({observer.realtime_factor:.2f} x real time)" if observer.realtime_factor else ""
                    progress.update(
                        task, completed=observer.time, description=f"{observer.motion or 'drilling'}{factor}"
                    )
            children["simulator"].check_alive()
            observer.drain(0.3)
            observer.destroy_node()
    finally:
        context.try_shutdown()


# --- the command ------------------------------------------------------------------------------------------------------


def options_from(arguments: Sequence[str]) -> DemoOptions:
    """The options of the command line."""
    defaults = DemoOptions()
    parser = argparse.ArgumentParser(prog="demo", description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=defaults.out, help="folder of the result (%(default)s)")
    parser.add_argument("--scene", default=defaults.scene, help="preset or scene file (%(default)s)")
    parser.add_argument("--duration", type=float, default=0.0, help="simulated time in seconds; 0: the scene's")
    parser.add_argument("--pace", default=defaults.pace, choices=("realtime", "fast", "lockstep"))
    parser.add_argument("--replace", action="store_true", help="move an older result to OUT.old")
    given = parser.parse_args(arguments)
    return DemoOptions(given.out, given.scene, given.duration, given.pace, given.replace)


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the demo with these command-line arguments."""
    run_demo(options_from(arguments), stop)
