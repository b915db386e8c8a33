# SPDX-License-Identifier: Apache-2.0
"""Node that follows simulated time, onset, motion state and diagnostics of a running twin."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from typing import ClassVar

from rclpy.context import Context

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import STRING_LEVEL, OnsetMessage, SubjectMotion
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import init_context
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.demo.processes import Child, StallDetector


class DemoObserver(TwinNode):
    """Latest values that the twin has published."""

    NAME: ClassVar = "demo"
    PURPOSE: ClassVar = "Observes a running twin."

    def __init__(self, context: Context, on_change: Callable[[str], None]) -> None:
        super().__init__(context)
        self.time = 0.0
        """Simulated time [s]."""
        self.onset: OnsetMessage | None = None
        """Onset, once it is published."""
        self.motion = ""
        """Motion state of the string."""
        self.realtime_factor = 0.0
        """Simulated over wall time [-]."""
        self.simulator: dict[str, str] = {}
        """Diagnostic values of the simulator."""
        self.compiling = ""
        """Progress of the simulator's compilation, while it compiles."""
        self._on_change = on_change
        self._problems: set[str] = set()
        self.topics.subscribe(CLOCK_TOPIC, self._on_clock)
        self.topics.subscribe(WHIRL_ONSET, self._on_onset)
        self.topics.subscribe(WHIRL_MOTION, self._on_motion)
        self.topics.subscribe(DIAGNOSTICS, self._on_diagnostics)

    def _on_clock(self, stamp: int) -> None:
        self.time = seconds(stamp)

    def _on_onset(self, found: tuple[int, OnsetMessage | None]) -> None:
        _, onset = found
        if onset is not None and onset != self.onset:
            self._on_change(f"whirl began at {onset.time:.2f} s at {onset.mark} (announced at {self.time:.2f} s)")
        self.onset = onset

    def _on_motion(self, found: tuple[int, list[SubjectMotion]]) -> None:
        stamp, motions = found
        for motion in motions:
            if motion.subject == STRING_LEVEL and motion.state != self.motion:
                self.motion = motion.state
                self._on_change(f"{motion.state} from {seconds(stamp):.2f} s: {motion.criterion}")

    def _on_diagnostics(self, found: tuple[int, list[Status]]) -> None:
        for status in found[1]:
            self.compiling = status.values.get("compiling", self.compiling)
            if "realtime_factor" in status.values:
                self.realtime_factor = float(status.values["realtime_factor"])
                self.simulator = dict(status.values)
                self.compiling = ""
            if (
                status.level in {Level.WARN, Level.ERROR}
                and (problem := f"{status.name}: {status.text}") not in self._problems
            ):
                self._problems.add(problem)
                self._on_change(problem)


def observed(
    children: Mapping[str, Child], stop: StopRequest, on_change: Callable[[str], None]
) -> Generator[DemoObserver, None, None]:
    """Observe running nodes; yields what has been seen so far, after each message or 0.1 s without one.

    Raises:
        RunError: A node ended with an error, or simulated time stands still.
    """
    context = init_context([], stop)
    stall_detector = StallDetector()
    try:
        observer = DemoObserver(context, on_change)
        try:
            while True:
                observer.spin_once(0.1)
                for child in children.values():
                    child.check_alive()
                stall_detector.check(observer.time, compiling=bool(observer.compiling))
                yield observer
        finally:
            observer.close()  # its executor first: one that outlives its context ends in a segmentation fault
    finally:
        context.try_shutdown()
