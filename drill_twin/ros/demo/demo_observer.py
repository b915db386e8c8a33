# SPDX-License-Identifier: Apache-2.0
"""Node that follows simulated time, onset, motion state and diagnostics of a running twin."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from rclpy.context import Context

from drill_twin.io.messages.decode import read_clock
from drill_twin.io.messages.diagnostics import Level, decode_diagnostics
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import STRING_LEVEL, OnsetMessage, decode_motion, decode_onset
from drill_twin.ros.core.node import TwinNode


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
        self.topics.subscribe(CLOCK_TOPIC, lambda raw, _: self._on_clock(raw))
        self.topics.subscribe(WHIRL_ONSET, lambda raw, _: self._on_onset(raw))
        self.topics.subscribe(WHIRL_MOTION, lambda raw, _: self._on_motion(raw))
        self.topics.subscribe(DIAGNOSTICS, lambda raw, _: self._on_diagnostics(raw))

    def _on_clock(self, raw: bytes) -> None:
        self.time = seconds(read_clock(raw))

    def _on_onset(self, raw: bytes) -> None:
        _, onset = decode_onset(raw)
        if onset is not None and onset != self.onset:
            self._on_change(
                f"whirl began at {onset.time:.2f} s at {onset.mark}, confidence {onset.confidence:.2f} "
                f"(announced at {self.time:.2f} s)"
            )
        self.onset = onset

    def _on_motion(self, raw: bytes) -> None:
        stamp, motions = decode_motion(raw)
        for motion in motions:
            if motion.subject == STRING_LEVEL and motion.state != self.motion:
                self.motion = motion.state
                self._on_change(f"{motion.state} from {seconds(stamp):.2f} s: {motion.criterion}")

    def _on_diagnostics(self, raw: bytes) -> None:
        _, statuses = decode_diagnostics(raw)
        for status in statuses:
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
