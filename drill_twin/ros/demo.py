# SPDX-License-Identifier: Apache-2.0
"""Demo: rig driver, simulator, analyzer and recorder in one process on DDS, observed, ended in order, and reported.

The demo's exit code is 0 only if every node ended well and the bag holds every topic of the contract.
"""

import argparse
import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from rclpy.context import Context
from rich.console import Console
from rich.progress import Progress

from drill_twin.core.errors import BagError, DrillTwinError, RunError
from drill_twin.core.files.output import RESULTS, make_folder, new_folder
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, OF_EVERY_RUN, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import STRING_LEVEL, OnsetMessage, SubjectMotion
from drill_twin.ros import composed_twin
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.stop_request import Stopped, StopRequest
from drill_twin.ros.deployment import own_domain

_STARTING_TIME = 150.0  # s in which the nodes compile and connect; not measured
_LAST = 0.3  # s in which the last messages arrive


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the demo with these command-line arguments.

    Raises:
        DrillTwinError: The demo cannot start, or (RunError) did not end well.
    """
    from drill_twin.scene import load_scene

    given = _parsed(arguments)
    out, console = given.out, Console(highlight=False)
    scene = load_scene(given.scene)
    duration = given.duration or scene.rig.duration
    if older := new_folder(out, replace=given.replace, results=(*RESULTS, "log")):
        console.print(f"the older result is now {older}")
    make_folder(out / "log")
    bag = out / "bag_0"
    parameters = {
        "scene": given.scene,
        "pace": given.pace,
        "duration": float(duration),
        "record": True,
        "bag": str(bag.absolute()),
        "wait_timeout": _STARTING_TIME,
    }
    file = (out / "log" / "parameters.yaml").absolute()
    file.write_text(json.dumps({"/**": {"ros__parameters": parameters}}), "utf-8")  # JSON is YAML
    with own_domain((out / "log").absolute()) as domain, suppress(Stopped):
        console.print(
            f"{scene.name}: {duration:g} s, {given.pace}; in another terminal: "
            f"[bold]ROS_DOMAIN_ID={domain} drill-twin ros doctor[/], or ros2 with ROS sourced"
        )
        with Progress(console=console, transient=True) as progress:
            # The nodes log to files only: lines on the console would tear the bar.
            observer = partial(DemoObserver, progress, float(duration))
            try:
                composed_twin.run(["--ros-args", "--disable-stdout-logs", "--params-file", str(file)], stop, observer)
            except DrillTwinError as error:
                raise RunError(str(error)) from error
    if stop:
        kept = f"the bag so far is {bag}" if bag.exists() else "nothing was recorded"
        raise RunError(f"stopped before it was over; the nodes ended in order, {kept}")
    check_bag(bag)
    _report(out, console)


# --- the observer -----------------------------------------------------------------------------------------------------


class DemoObserver(TwinNode):
    """Shows simulated time, onset, motion state and problems of a running twin."""

    NAME = "demo"
    PURPOSE = "Observes a running twin."

    def __init__(self, progress: Progress, duration: float, context: Context, others: Iterable[str] = ()) -> None:
        """Begin to show a run of a duration [s]; `TwinNode` explains the other arguments."""
        super().__init__(context, others)
        self._progress, self._task = progress, progress.add_task("compiling and connecting", total=duration)
        self._tell, self._time = progress.console.print, 0.0  # s, simulated
        self._onset: OnsetMessage | None = None
        self._motion = self._compiling = self._factor = ""
        self._problems: set[str] = set()

    def configure(self) -> None:
        """Subscribe to clock, findings and diagnostics."""
        self.topics.subscribe(CLOCK_TOPIC, self._on_clock)
        self.topics.subscribe(WHIRL_ONSET, self._on_onset)
        self.topics.subscribe(WHIRL_MOTION, self._on_motion)
        self.topics.subscribe(DIAGNOSTICS, self._on_diagnostics)

    def complete(self) -> None:
        """Tell what still arrives."""
        self.drain(_LAST)

    def step(self) -> None:
        """Show what has come."""
        self.spin_once(0.1)
        if self._compiling:
            self._progress.update(self._task, description=self._compiling)
        if self._time > 0.0:
            shown = f"{self._motion or 'drilling'}{self._factor}"
            self._progress.update(self._task, completed=self._time, description=shown)

    def _on_clock(self, stamp: int) -> None:
        self._time = seconds(stamp)

    def _on_onset(self, found: tuple[int, OnsetMessage | None]) -> None:
        _, onset = found
        if onset is not None and onset != self._onset:
            self._tell(f"whirl began at {onset.time:.2f} s at {onset.mark} (announced at {self._time:.2f} s)")
        self._onset = onset

    def _on_motion(self, found: tuple[int, list[SubjectMotion]]) -> None:
        stamp, motions = found
        for motion in motions:
            if motion.subject == STRING_LEVEL and motion.state != self._motion:
                self._motion = motion.state
                self._tell(f"{motion.state} from {seconds(stamp):.2f} s: {motion.criterion}")

    def _on_diagnostics(self, found: tuple[int, list[Status]]) -> None:
        for status in found[1]:
            self._compiling = status.values.get("compiling", self._compiling)
            if factor := status.values.get("realtime_factor"):
                self._compiling = ""
                self._factor = f" ({float(factor):.2f} x real time)" if float(factor) else ""
            problem = f"{status.name}: {status.text}"
            if status.level in {Level.WARN, Level.ERROR} and problem not in self._problems:
                self._problems.add(problem)
                self._tell(problem)


# --- the result -------------------------------------------------------------------------------------------------------


def check_bag(folder: Path) -> None:
    """Check that the bag is complete and holds every topic that each run has.

    Raises:
        RunError: The bag is damaged, or a topic has no message.
    """
    from drill_twin.io.bag.reader import Bag

    try:
        bag = Bag(folder)
    except BagError as error:
        raise RunError(str(error)) from error
    missing = [name for name in OF_EVERY_RUN if name not in bag.topics or not bag.topics[name].count]
    if missing:
        raise RunError(f"{folder}: expected every topic of the contract, found no message on {', '.join(missing)}")
    if bag.truncated:
        raise RunError(f"{folder}: expected a whole bag, found {'; '.join(bag.damage)}")


def _report(out: Path, console: Console) -> None:
    """Write the report of the bag in a folder, and print its findings."""
    from drill_twin.core.table import Table
    from drill_twin.report import build_report
    from drill_twin.report.verdict import first_rows, verdict

    with console.status("drawing the report"):
        build_report(out / "bag_0", out)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    for sentence in verdict(summary, str(out / "bag_0")):
        console.print(sentence, markup=False)
    console.print(Table((), list(first_rows(summary))))
    console.print(
        f"[bold]{out / 'report.html'}[/]  (bag: {out / 'bag_0'}, figures: {out}/*.png, {out / 'summary.json'})"
    )


def _parsed(arguments: Sequence[str]) -> argparse.Namespace:
    """Options of the command line, with the duration in s."""
    from drill_twin.api.scenes import in_si
    from drill_twin.core.units.dimension import TIME

    parser = argparse.ArgumentParser(
        prog="drill-twin ros demo",
        description="Run a scene as ROS 2 nodes on this machine, record it, and draw the report.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="new folder of the result (%(default)s)")
    parser.add_argument(
        "--scene", default="pa6_bench", help="name of an installed scene, or a scene file (%(default)s)"
    )
    parser.add_argument("--duration", default="0", help='simulated time, as "30 s" or in s; 0: the scene\'s')
    parser.add_argument(
        "--pace",
        default="realtime",
        choices=("realtime", "fast", "lockstep"),
        help="pace of the simulator; lockstep: as fast as possible, and the same frames each time",
    )
    parser.add_argument("--replace", action="store_true", help="replace an older result, which is moved to OUT.old")
    given = parser.parse_args(arguments)
    given.duration = in_si("--duration", given.duration, TIME)
    return given
