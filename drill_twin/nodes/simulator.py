# SPDX-License-Identifier: Apache-2.0
"""The simulator: set-points in, the moving string out, in real time, as fast as possible, or in lockstep.

Each turn of its loop takes the commands that have come, lets the twin take one frame's worth of steps (compiled, with
the GIL released), publishes the frame, and waits until the next one is due. Simulated time starts at 0 with the first
good command.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from rclpy.context import Context

from drill_twin.cost import Cost
from drill_twin.errors import DrillTwinError, MessageError
from drill_twin.frame import Frame
from drill_twin.messages.decode import JointStateReader, read_float64
from drill_twin.messages.diagnostics import Level, Status
from drill_twin.messages.encode import TwinEncoder, encode_string, read_command
from drill_twin.messages.stamps import stamp_ns
from drill_twin.messages.topics import (
    CLOCK_TOPIC,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    STRING_MARKERS,
    STRING_POSES,
    TWIN_SCENE,
    WOB_COMMAND,
)
from drill_twin.nodes.base import Tick, TwinNode, run_node
from drill_twin.nodes.commands import CommandDesk, Silence
from drill_twin.nodes.limits import limits_for
from drill_twin.nodes.pacing import Pacer
from drill_twin.nodes.parameters import Parameter, Value
from drill_twin.nodes.scenes import OVERRIDES, SCENE, scene_of
from drill_twin.nodes.start import StopRequest
from drill_twin.schedule.command import Command

_TURN = 6.283185307179586
_LEASE = 6.0  # s; a killed node has left the graph by then
_BURST = 200  # frames; as fast as possible must not be faster than the readers
_DISCOVERY = 0.6  # s; a living node has been found by then


class Simulator(TwinNode):
    """Moves the string of a scene under the commands it receives."""

    NAME: ClassVar = "simulator"
    PURPOSE: ClassVar = "Moves the drillstring of a scene under the set-points it receives."
    PARAMETERS: ClassVar = (
        SCENE,
        OVERRIDES,
        Parameter(
            "pace",
            "realtime",
            "realtime: frames at their wall-clock times; fast: as fast as possible; lockstep: each frame waits for the "
            "command stamped for it, so that a run is repeatable",
            choices=("realtime", "fast", "lockstep"),
        ),
        Parameter("frame_rate", 0.0, "published frames per simulated second; 0: as the scene says", "Hz", 0.0, 1000.0),
        Parameter("duration", 0.0, "simulated time after which the node ends; 0: runs until stopped", "s", 0.0, 1e6),
        Parameter("wait_for_command", True, "whether simulated time stands still until the first good command"),
        Parameter("command_timeout", 1.0, "wall time without a command that counts as silence", "s", 0.05, 3600.0),
        Parameter(
            "on_silence",
            "hold",
            "what follows silence: hold the last set-point, or ramp to the safe one",
            choices=("hold", "ramp"),
        ),
        Parameter("safe_weight_on_bit", 0.0, "weight on bit of the safe set-point", "N", -1e7, 1e7),
        Parameter("safe_speed", 0.0, "top-drive speed of the safe set-point", "rev/s", -100.0, 100.0),
        Parameter("safe_ramp_time", 5.0, "time of the ramp to the safe set-point, simulated", "s", 0.0, 3600.0),
        Parameter(
            "max_weight_on_bit", 0.0, "larger commands are refused; 0: ten times the scene's largest", "N", 0.0, 1e8
        ),
        Parameter(
            "max_speed", 0.0, "faster commands are refused; 0: ten times the scene's fastest", "rev/s", 0.0, 100.0
        ),
        Parameter("negative_commands", False, "whether tension and left-hand rotation may be commanded"),
        Parameter("marker_rate", 25.0, "pictures for RViz and Foxglove, per second of wall time", "Hz", 0.0, 100.0),
        Parameter(
            "exaggeration",
            0.0,
            "factor by which the picture widens lateral motion; 0: chosen by size",
            "",
            0.0,
            10000.0,
        ),
    )

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, also_known: Sequence[str] = ()
    ) -> None:
        super().__init__(context, values, also_known)
        self._born = time.monotonic()
        self._read_command = JointStateReader().read
        self._twin: Any = None
        self._frame: Frame | None = None
        self._frames = 0
        self._started_at: float | None = None
        self._cost = Cost()

    # --- start ----------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Load the scene, compile and build the twin, and announce it."""
        # Imported here: compiling takes long, and a bad parameter should be refused before.
        from drill_twin.twin import Twin
        from drill_twin.wiring import describe_run, string_geometry

        settings = self.settings
        scene = scene_of(settings)
        self._rate = settings.frame_rate or scene.numerics.frame_rate
        self._seconds = 1.0 / self._rate
        safe = Command(settings.safe_weight_on_bit, settings.safe_speed * _TURN)
        silence = Silence(settings.command_timeout, settings.on_silence == "ramp", safe, settings.safe_ramp_time)
        limits = limits_for(
            scene,
            max_weight_on_bit=settings.max_weight_on_bit,
            max_speed=settings.max_speed * _TURN,
            negative=settings.negative_commands,
        )
        first = Command(scene.rig.weight_on_bit.initial, scene.rig.rotation.initial)
        self._desk = CommandDesk(limits, silence, first)
        self._pacer = Pacer(self._seconds)
        self._picture = Tick(1.0 / settings.marker_rate) if settings.marker_rate else None
        for topic in (RIG_STATE, STRING_POSES, MARKS_STATE, STRING_MARKERS, TWIN_SCENE):
            self.advertise(topic)
        # Latched, so that a driver which comes back in mid-run learns at once what time it is.
        self.advertise(CLOCK_TOPIC, latched=True)
        # A first frame of another twin compiles the kernel: time must not stand still once it runs.
        Twin(scene).step(first, self._seconds)
        self._twin = Twin(scene)
        self._encoder = TwinEncoder(string_geometry(scene, self._twin.elements))
        self._refuse_a_second_one()
        self.outgoing[TWIN_SCENE].publish(encode_string(describe_run(self._twin, settings.pace)))
        self.outgoing[CLOCK_TOPIC].publish(self._encoder.clock(0.0))
        self.listen(RIG_COMMAND, self._on_command)
        self.listen(WOB_COMMAND, lambda raw, _: self._on_single(raw, self._desk.weight_on_bit))
        self.listen(RPS_COMMAND, lambda raw, _: self._on_single(raw, self._desk.speed))
        self.get_logger().info(
            f"{scene.name}: {self._twin.elements} elements, {self._twin.step_size * 1e6:.0f} us steps, "
            f"{self._rate:g} frames/s, {settings.pace}"
        )

    def _refuse_a_second_one(self) -> None:
        time.sleep(max(self._born + _DISCOVERY - time.monotonic(), 0.0))
        deadline = time.monotonic() + _LEASE
        while len(others := self.publishers_of(STRING_POSES)) > 1:
            if time.monotonic() > deadline:
                raise DrillTwinError(
                    f"expected to be the only simulator here, found {len(others) - 1} more that publishes "
                    f"{STRING_POSES} in ROS_DOMAIN_ID={self.context.get_domain_id()}; stop it, or choose "
                    "another domain or namespace"
                )
            self.listen_for(0.1)

    # --- one turn of the loop -------------------------------------------------------------------------------------

    def work(self) -> None:
        """Take one frame, or wait for what it needs."""
        self.take_all()
        if self._must_wait():
            self._pacer.restart()
            self.listen_for(0.05)
            return
        self.listen_for(0.0)
        if self._started_at is None:
            self._started_at = time.monotonic()
        self._advance()
        if self.settings.pace == "realtime":
            self._pacer.wait()
        elif self.settings.pace == "fast" and self._frames % _BURST == 0:
            self.flush(1.0)

    def _must_wait(self) -> bool:
        if self._started_at is None and self.settings.wait_for_command and not self._desk.heard:
            return True
        return self.settings.pace == "lockstep" and self._desk.last_stamp <= stamp_ns(self._twin.time)

    def _advance(self) -> None:
        begin = time.perf_counter()
        frame = self._twin.step(self._desk.set_point(self._seconds), self._seconds)
        stepped = time.perf_counter()
        send, encoder = self.outgoing, self._encoder
        send[RIG_STATE].publish(encoder.rig_state(frame))
        send[MARKS_STATE].publish(encoder.marks(frame))
        send[STRING_POSES].publish(encoder.poses(frame))
        if self._picture_due():
            send[STRING_MARKERS].publish(encoder.markers(frame, self.settings.exaggeration or None))
        # Last: who answers the clock can rely on the frame being out.
        send[CLOCK_TOPIC].publish(encoder.clock(frame.time))
        self._frame = frame
        self._frames += 1
        self._cost.add(self._seconds, stepped - begin, time.perf_counter() - stepped, frame)

    def _picture_due(self) -> bool:
        """In lockstep by simulated time, so that runs are alike; else by the wall clock, for the eyes."""
        if self.settings.pace != "lockstep" or self._picture is None:
            return self._picture is not None and self._picture.due()
        return self._frames % max(round(self._rate / self.settings.marker_rate), 1) == 0

    @property
    def finished(self) -> bool:
        """Whether the wanted duration has been simulated."""
        wanted = self.settings.duration
        return bool(wanted) and self._twin.time >= wanted - 0.5 * self._seconds

    def close(self) -> None:
        """Say how it went, and see that the readers have received everything."""
        if self._frame is not None:
            self.report_health()
            self.flush()
            self.get_logger().info(f"{self._twin.time:.2f} s simulated, {self._cost.sentence()}")

    # --- commands -------------------------------------------------------------------------------------------------

    def _on_command(self, raw: bytes, info: Mapping[str, Any]) -> None:
        del info
        try:
            state = self._read_command(raw)
            command = read_command(state)
        except MessageError as error:
            self._desk.malformed(str(error))
            return
        self._desk.both(state.stamp, command)

    def _on_single(self, raw: bytes, deliver: Any) -> None:
        try:
            value = read_float64(raw)
        except MessageError as error:
            self._desk.malformed(str(error))
            return
        deliver(value, driver_present=self.count_publishers(self.resolve_topic_name(RIG_COMMAND.lstrip("/"))) > 0)

    # --- diagnostics ----------------------------------------------------------------------------------------------

    def not_ready(self) -> str:
        """Why the twin cannot be driven yet; empty when it can."""
        return "" if self._twin is not None else "the twin is being compiled"

    def health(self) -> Status:
        """Pace, cost, set-points and where they come from."""
        desk = self._desk
        desk.settle_doubts()
        sources = self._sources()
        values = {
            "scene": self.settings.scene,
            "pace": self.settings.pace,
            "simulated_time": f"{self._twin.time:.6f}",
            "frames": str(self._frames),
            **self._cost.values(),
            "overruns": str(self._pacer.overruns),
            "time_given_up": f"{self._pacer.given_up:.3f}",
            "elements": str(self._twin.elements),
            "step_s": repr(float(self._twin.step_size)),
            "weight_on_bit": f"{desk.good.weight_on_bit:g}",
            "speed_rev_s": f"{desk.good.rotation / _TURN:g}",
            "command_age": f"{desk.age:.3f}",
            "commands_accepted": str(desk.accepted),
            "commands_refused": str(sum(desk.refused.values())),
            **{f"commands_refused_{kind}": str(count) for kind, count in sorted(desk.refused.items())},
            "last_refusal": desk.last_refusal,
            "command_sources": ", ".join(sources),
            "commands_from_others": str(desk.from_others),
        }
        self._cost.next_window()
        level, text = self._verdict(sources)
        return Status(self.NAME, level, text, values)

    def _verdict(self, sources: list[str]) -> tuple[Level, str]:
        desk = self._desk
        if len(self.publishers_of(STRING_POSES)) > 1:
            return Level.ERROR, f"another simulator publishes {STRING_POSES} in this domain and namespace"
        if self._must_wait() and not desk.heard:
            return Level.OK, "waiting for the first command"
        if len(sources) > 1 or desk.from_others:
            others = "" if len(sources) > 1 else f"; {desk.from_others} single values from others were not followed"
            return Level.WARN, f"more than one source of commands: {', '.join(sources)}{others}"
        if desk.silent:
            held = "ramping to the safe set-point" if self.settings.on_silence == "ramp" else "the last one is held"
            waiting = "the lockstep waits" if self.settings.pace == "lockstep" else held
            return Level.WARN, f"no command for {desk.age:.1f} s; {waiting}"
        if desk.refused:
            return Level.WARN, f"commands were refused; the last: {desk.last_refusal}"
        return Level.OK, self._cost.sentence()

    def _sources(self) -> list[str]:
        """Who commands: all publishers of `/rig/command`, and those of single values who are none of these."""
        drivers = self.publishers_of(RIG_COMMAND)
        singles = {*self.publishers_of(WOB_COMMAND), *self.publishers_of(RPS_COMMAND)} - set(drivers)
        return [*drivers, *sorted(singles)]


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the simulator."""
    run_node(Simulator, arguments, stop)
