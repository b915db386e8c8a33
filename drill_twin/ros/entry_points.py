# SPDX-License-Identifier: Apache-2.0
"""Entry points of the nodes: signals first, then the imports, then the node; one line and an exit code for an error.

Exit codes: 0 ended as asked (also by SIGINT or SIGTERM), 1 the run could not go on, 2 refused to start.
"""

from __future__ import annotations

import importlib
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from drill_twin.errors import DrillTwinError, RunError

NODES = {
    "simulator": "drill_twin.ros.simulator.node",
    "rig_driver": "drill_twin.ros.rig_driver.node",
    "analyzer": "drill_twin.ros.analyzer.node",
    "recorder": "drill_twin.ros.bag.recorder",
    "replayer": "drill_twin.ros.bag.replayer",
    "twin": "drill_twin.ros.composed_twin",
    "demo": "drill_twin.ros.demo.demo",
    "watch": "drill_twin.ros.live_page",
}
"""What can be started, and the module with its `run`."""
_REMINDER = 0.02  # s until a signal that came in mid-import is looked at again


class Stopped(BaseException):
    """A signal came while the node was still starting; not an Exception, so that nothing swallows it."""


class StopRequest:
    """Becomes true once, on SIGINT or SIGTERM. `with request.at_once()`: a signal ends the block immediately."""

    def __init__(self) -> None:
        self._asked = False
        self._at_once = False
        self._reminded = False

    def __bool__(self) -> bool:
        return self._asked

    def set(self) -> None:
        """Ask to stop, as a signal would."""
        self._asked = True

    def install(self) -> None:
        """Take over both signals; only the main thread of a process can."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):  # the last one is our own reminder
            signal.signal(number, self._on_signal)

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Within this block a signal raises Stopped: for long work that has nothing to put in order."""
        self._at_once = True
        try:
            if self._asked:
                raise Stopped
            yield
        finally:
            self._at_once = False
            if self._reminded:  # it must not ring once the interpreter is gone
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                self._reminded = False

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        del number
        self._asked = True
        if not self._at_once:
            return
        if _imports(frame):
            self._reminded = True
            signal.setitimer(signal.ITIMER_REAL, _REMINDER)
            return
        self._at_once = False
        raise Stopped


def _imports(frame: FrameType | None) -> bool:
    """Whether a module is being imported: an exception there can leave the lock of all imports locked for ever."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def start(node: str, arguments: Sequence[str] | None = None) -> int:
    """Run one node of this package until it ends or is asked to; returns the exit code."""
    stop = StopRequest()
    stop.install()
    try:
        with stop.at_once():
            try:
                module = importlib.import_module(NODES[node])
            except ModuleNotFoundError as error:
                raise _missing(error) from error
        module.run(list(sys.argv[1:] if arguments is None else arguments), stop)
    except Stopped:
        if node != "demo":  # a node was asked to end, and did; a demo that never drilled has not succeeded
            return 0
        print("demo: error: stopped before it began; nothing was recorded", file=sys.stderr, flush=True)
        return 1
    except DrillTwinError as error:
        print(f"{node}: error: {error}", file=sys.stderr, flush=True)
        return 1 if isinstance(error, RunError) else 2
    return 0


def _missing(error: ModuleNotFoundError) -> DrillTwinError:
    remedy = "source /opt/ros/jazzy/setup.bash, or run `make setup` and use .venv/bin/python"
    if error.name and not error.name.startswith(("rclpy", "rcl_", "std_", "sensor_", "geometry_", "diagnostic_")):
        remedy = "run `make setup`, or pip install the requirements of drill_twin into this Python"
    return DrillTwinError(f"expected the Python module {error.name!r}, found none in {sys.prefix}; {remedy}")


def simulator() -> None:
    """`ros2 run drill_twin simulator`."""
    sys.exit(start("simulator"))


def rig_driver() -> None:
    """`ros2 run drill_twin rig_driver`."""
    sys.exit(start("rig_driver"))


def analyzer() -> None:
    """`ros2 run drill_twin analyzer`."""
    sys.exit(start("analyzer"))


def recorder() -> None:
    """`ros2 run drill_twin recorder`."""
    sys.exit(start("recorder"))


def replayer() -> None:
    """`ros2 run drill_twin replayer`."""
    sys.exit(start("replayer"))


def twin() -> None:
    """`ros2 run drill_twin twin`."""
    sys.exit(start("twin"))
