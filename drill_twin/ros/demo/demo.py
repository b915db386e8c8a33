# SPDX-License-Identifier: Apache-2.0
"""The demo: rig driver, simulator, analyzer and recorder as processes on DDS, watched, ended in order, and reported.

Its exit code is 0 only if every node ended well and the bag holds every topic of the contract.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drill_twin.errors import DrillTwinError, RunError
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.demo.result import check_bag, draw_report
from drill_twin.ros.deployment.processes import processes

_STARTING = 150.0  # s to compile and connect
_PATIENCE = 5.0  # simulated seconds may take this many times as long
_LOST_DRIVER = 20.0  # s without simulated time going on


@dataclass(frozen=True)
class DemoOptions:
    """What the demo runs and where it leaves the result."""

    out: Path = Path("out/demo")
    """Folder of the result."""
    scene: str = "pa6_bench"
    """Scene: preset or path."""
    duration: float = 0.0
    """Simulated time [s]; 0: the scene's."""
    pace: str = "realtime"
    """Pace of the simulator: realtime, fast or lockstep."""
    replace: bool = False
    """Whether an older result is moved aside, to `<out>.old`."""


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
    prepare_folder(options)
    claim = DomainClaim(domain_of_environment())
    os.environ["ROS_DOMAIN_ID"] = str(claim.domain)
    os.environ["ROS_LOG_DIR"] = str((options.out / "log").absolute())
    prepare()
    try:
        console.print(
            f"{scene.name}: {duration:g} s, {options.pace}; in another terminal, with ROS sourced: "
            f"[bold]ROS_DOMAIN_ID={claim.domain} ros2 topic list[/]"
        )
        _drill(options, duration, console, stop)
    finally:
        claim.release()
    if stop:
        raise RunError(
            f"stopped before it was over; the nodes ended in order, the bag so far is {options.out / 'bag_0'}"
        )
    check_bag(options.out / "bag_0")
    draw_report(options.out, console)


def prepare_folder(options: DemoOptions) -> None:
    """Make the folder of the result; an older one is moved aside when that is wanted.

    Raises:
        DrillTwinError: It exists, or cannot be made.
    """
    out = options.out
    try:
        if out.exists():
            if not options.replace:
                raise DrillTwinError(
                    f"{out}: expected a new folder, found one that exists; choose another, or --replace"
                )
            _move_aside(out)
        (out / "log").mkdir(parents=True)
    except OSError as error:
        raise DrillTwinError(
            f"{out}: expected a place to write the result, found {error.strerror or error}; choose another with --out"
        ) from error


def _move_aside(out: Path) -> None:
    """`out` becomes `out.old`; only what a demo left there is ever removed."""
    import shutil

    old = out.with_name(out.name + ".old")
    if not _is_result(out):
        raise DrillTwinError(
            f"{out}: expected the result of an earlier demo, found something else; choose another --out"
        )
    if old.exists():
        if not _is_result(old):
            raise DrillTwinError(f"{old}: expected the result of an earlier demo, found something else; move it away")
        shutil.rmtree(old)
    out.rename(old)


def _is_result(folder: Path) -> bool:
    return folder.is_dir() and not folder.is_symlink() and ((folder / "log").is_dir() or not any(folder.iterdir()))


# --- the processes ----------------------------------------------------------------------------------------------------


def _commands(options: DemoOptions, duration: float) -> dict[str, Mapping[str, object]]:
    """Nodes and their parameters, in the order in which they are ended: who listens outlives who speaks."""
    return {
        "simulator": {"scene": options.scene, "pace": options.pace, "duration": float(duration)},
        "rig_driver": {
            "scene": options.scene,
            "wait_for": "simulator analyzer recorder",
            "wait_timeout": _STARTING,
        },
        "analyzer": {},
        "recorder": {"bag": str((options.out / "bag_0").absolute())},
    }


def _drill(options: DemoOptions, duration: float, console: Any, stop: StopRequest) -> None:
    """Run the nodes until the simulator is done."""
    environment = dict(os.environ, PYTHONUNBUFFERED="1")
    with processes(_commands(options, duration), environment, options.out / "log") as children:
        _watch(children, duration, console, stop)


def _watch(children: Mapping[str, Any], duration: float, console: Any, stop: StopRequest) -> None:
    """Show how the run goes on, until the simulator ends.

    Raises:
        RunError: A node ended with an error, or simulated time stands still.
    """
    # Imported after the children were started: a fork must not meet the threads of DDS.
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
            watcher = DemoObserver(context, progress.console.print)
            task = progress.add_task("compiling and connecting", total=duration)
            patience = Patience()
            while not stop and children["simulator"].exit_code is None:
                watcher.spin_once(0.1)
                for child in children.values():
                    child.check_alive()
                patience.check(watcher.time)
                if watcher.time > 0.0:
                    factor = f" ({watcher.realtime_factor:.1f} x real time)" if watcher.realtime_factor else ""
                    progress.update(task, completed=watcher.time, description=f"{watcher.motion or 'drilling'}{factor}")
            children["simulator"].check_alive()
            watcher.drain(0.3)
            watcher.destroy_node()
    finally:
        context.try_shutdown()


class Patience:
    """Gives up on a run whose simulated time stands still."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._since, self._time = clock(), 0.0

    def check(self, simulated: float) -> None:
        """Look at the simulated time [s].

        Raises:
            RunError: It has stood still for too long.
        """
        now = self._clock()
        if simulated != self._time:
            self._since, self._time = now, simulated
        limit = _LOST_DRIVER if simulated else _STARTING
        if now - self._since > limit:
            raise RunError(f"simulated time has stood at {simulated:.2f} s for {limit:g} s; see the logs of the nodes")


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
