# SPDX-License-Identifier: Apache-2.0
"""Estimator node: an ensemble that follows what a rig measures; the node commands nothing."""

import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import TypeVar

import numpy as np

from drill_twin.core.errors import RunError, RunStopped
from drill_twin.dynamics.solver.slices import checked
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.encode import TwinEncoder, encode_string
from drill_twin.io.messages.good_samples import GoodSamples
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.sensor_messages import ImuReading
from drill_twin.io.messages.stamps import NANOSECONDS, seconds, stamp_ns
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    ESTIMATE,
    ESTIMATE_STATE,
    MEASURED_RIG_STATE,
    OF_NEAREST_TWIN,
    RIG_COMMAND,
    RIG_STATE,
    TWIN_SCENE,
)
from drill_twin.io.scene_geometry import readings_topic, string_geometry
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import Rights
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE, pairs_of, scene_of
from drill_twin.runs import compile_kernel
from drill_twin_studies.api.estimator import Estimator as Following
from drill_twin_studies.estimation import Estimate, EstimatorOptions
from drill_twin_studies.ros.estimator.messages import (
    encode_estimate,
    nearest_twin,
    trust_in,
    values_for_diagnostics,
    values_of,
    verdict_of,
)

_DEPTH = 1000  # messages that wait while another thread has the processor
_BEHIND = 10  # windows that wait before the oldest is left out
_LONGEST_PATIENCE = 4.0  # s; a sample that is 5 s later than the last one is a jump of the clock

Result = TypeVar("Result")


class Estimator(TwinNode):
    """Feeds an ensemble with what is measured, and publishes what it finds."""

    NAME = "estimator"
    PURPOSE = "Follows a rig with an ensemble: numbers, virtual sensors, chance of whirl, alarm."
    PARAMETERS = (
        SCENE,
        OVERRIDES,
        Parameter(
            "free", ("load_factor=0.8..1.2",), "free numbers and their ranges as KEY=LO..HI",
            such_as='["wall_friction.coefficient=0.1..0.4", "load_factor=0.8..1.2"]', between=";",
        ),
        Parameter(
            "channels", ("torque", "hookload"),
            "channels that correct: torque, or motor_torque with inertia and bearings of the drive; hookload, "
            "top_drive_speed, bit_speed",
        ),
        Parameter(
            "subs", (),
            "downhole subs of the scene whose readings correct, by name; of a real rig as measured/NAME",
            such_as='["measured/near_bit"]',
        ),
        Parameter(
            "set_points", "command", "where set-points come from: /rig/command, the measured message, or the scene", "",
            choices=("command", "measured", "scene"),
        ),
        Parameter("members", 64, "members of the ensemble", "", 4, 1000),
        Parameter("window", 1.0, "time from estimate to estimate", "s", 0.05, 60.0),
        Parameter("rate", 10.0, "samples a second that are compared", "Hz", 0.1, 1000.0),
        Parameter("error", 0.02, "error of a sample, over the largest value of its channel", "", 1e-6, 1.0),
        Parameter(
            "horizon", 4.0, "time ahead for which the chance of whirl is computed; 0: not computed", "s", 0.0, 60.0
        ),
        Parameter("show", True, "publish the member nearest to the rig under estimate/"),
        Parameter("seed", 1, "seed of the draws", "", 0, 2**31 - 1),
        AUTOSTART,
    )  # fmt: skip
    RIGHTS = Rights(
        (DIAGNOSTICS, MEASURED_RIG_STATE, RIG_STATE, RIG_COMMAND, "/downhole/*/imu", "/measured/downhole/*/imu"),
        publishes=tuple(ESTIMATE + topic for topic in OF_NEAREST_TWIN),
    )
    ON_CHANGE = (RIG_COMMAND,)
    TIMED_BY = MEASURED_RIG_STATE
    _thread: ThreadPoolExecutor
    """Thread of the ensemble; made by `configure`."""

    def configure(self) -> None:
        """Create topics, and begin to make the ensemble on a thread of its own.

        Raises:
            DrillTwinError: Scene, numbers or channels cannot be taken.
        """
        self._set_points: dict[str, float] = {}
        self._following: Following | None = None
        self._nearest: TwinEncoder | None = None
        self._found: Estimate | None = None
        self._heard: tuple[float, float] | None = None  # stamp of the last sample, and when it came [s]
        self._alone = 0.0  # s since then, for which the ensemble has run alone
        self._channels = GoodSamples()
        self._making, self._closing = "making the ensemble", False
        self._thread = ThreadPoolExecutor(1, "ensemble")
        self._made: Future[Following] | None = self._thread.submit(self._stoppable, self._make)
        self._step: Future[Estimate | None] | None = None
        self.topics.advertise(ESTIMATE_STATE)
        if self.settings.show:
            self.topics.prefix = self.get_namespace().rstrip("/") + ESTIMATE
            for topic in OF_NEAREST_TWIN:
                self.topics.advertise(topic)
            self.topics.prefix = ""
        self.topics.subscribe(MEASURED_RIG_STATE, self._on_measured, depth=_DEPTH)
        self.samples.expect(MEASURED_RIG_STATE)
        for sub in self.settings.subs:
            self.topics.subscribe(readings_topic(sub), partial(self._on_readings, sub), depth=_DEPTH)
        if self.settings.set_points == "command":
            self.topics.subscribe(RIG_COMMAND, self._on_command, depth=_DEPTH)

    def complete(self) -> None:
        """End a compilation, or the window that is being computed."""
        self._closing = True
        if hasattr(self, "_thread"):
            self._thread.shutdown(cancel_futures=True)

    def not_ready(self) -> str:
        """Reason while the ensemble is being made."""
        return "" if self._following is not None else self._making

    def step(self) -> None:
        """Take what has arrived, publish what has been found, and begin the next window."""
        super().step()
        if self._made is not None and self._made.done():
            self._begin(self._made.result())
            self._made = None
        if self._following is None:
            return
        if self._step is not None and self._step.done():
            self._publish(self._following, self._step.result())
            self._step = None
        self._let_time_pass(self._following)
        while len(self._following.intake.ready) > _BEHIND:
            self._following.intake.skip()
        if self._step is None and self._following.intake.ready:
            self._step = self._thread.submit(self._stoppable, self._following.step)

    def _stoppable(self, function: Callable[[], Result]) -> Result:
        """Call a function on the thread; `complete` ends what it computes."""

        def check() -> None:
            if self._closing:
                raise RunStopped

        with checked(check):
            return function()

    def _make(self) -> Following:
        """Make the ensemble; its kernels are compiled by a child process, which `complete` ends at once."""
        settings, scene = self.settings, scene_of(self.settings)
        free = pairs_of("free", settings.free)
        compile_kernel(scene, scene.numerics.frame_period, self._on_compilation)
        names = ("members", "window", "rate", "error", "horizon", "seed")
        options = EstimatorOptions(frames=settings.show, **{name: getattr(settings, name) for name in names})
        return Following(scene, free, channels=settings.channels, subs=settings.subs, options=options)

    def _on_compilation(self, progress: str) -> None:
        self._making = progress
        if self._closing:
            raise RunError(f"stopped while {progress}")

    def _begin(self, following: Following) -> None:
        self._following = following
        if self.settings.show:
            self._nearest = TwinEncoder(string_geometry(following.scene, following.filter.members.twins[0].rod.arc))
            self.topics.publish(TWIN_SCENE, encode_string(following.scene.to_yaml()))
        self.samples.expect(MEASURED_RIG_STATE)  # from now on
        self.get_logger().info(f"{len(following.filter.members)} members of {following.scene.name} follow the rig")

    def _on_command(self, state: JointState) -> None:
        known = {name: value for name, value in read_command(state)._asdict().items() if math.isfinite(value)}
        self.samples.take(RIG_COMMAND, finite=bool(known))
        self._set_points |= known

    def _on_measured(self, state: JointState) -> None:
        if self._following is None:
            return
        values = values_of(state, set_points=self.settings.set_points == "measured")
        in_order = self._following.take(seconds(state.stamp), values | self._set_points)
        stamp = seconds(state.stamp) if in_order or self._heard is None else self._heard[0]
        self._heard, self._alone = (stamp, self._now), 0.0
        finite = {name: math.isfinite(values[name]) for name in self._following.channels}
        self.samples.take(MEASURED_RIG_STATE, finite=any(finite.values()), in_order=in_order)
        for name, known in finite.items():
            self._channels.take(f"{name} of {MEASURED_RIG_STATE}", finite=known, in_order=in_order)

    @property
    def _now(self) -> float:
        """Time of this node's clock [s], which is simulated with `use_sim_time`."""
        return self.get_clock().now().nanoseconds / NANOSECONDS

    def _let_time_pass(self, following: Following) -> None:
        """Let the time of a rig that is silent go on by this node's clock: the ensemble runs on alone.

        A rig that says that its time stands still is waited for.
        """
        if self._heard is None or self.samples.rests:
            return
        stamp, since = self._heard
        alone = self._now - since
        patience = min(self.samples.patience(MEASURED_RIG_STATE), _LONGEST_PATIENCE)
        if alone > patience and alone - self._alone >= self.settings.window:
            self._alone = alone
            following.take(stamp + alone, self._set_points)

    def _on_readings(self, sub: str, reading: ImuReading) -> None:
        if self._following is None:
            return
        self.samples.take(readings_topic(sub), finite=bool(np.isfinite(reading.values).any()))
        self._following.take_readings(seconds(reading.stamp), sub, reading.values)

    def _publish(self, following: Following, found: Estimate | None) -> None:
        if found is None:
            return
        if found.alarm and (self._found is None or not self._found.alarm):
            self.get_logger().warning(found.alarm)
        self._found = found
        origin = following.intake.origin or 0.0
        stamp = stamp_ns(max(origin + found.time, 0.0))
        self.topics.publish(ESTIMATE_STATE, encode_estimate(stamp, found))
        self.publish_diagnostics()  # the sentence on it
        if self._nearest is not None and found.frames is not None:
            for topic, raw in nearest_twin(self._nearest, found.frames, origin):
                self.topics.publish(topic, raw)

    def health(self) -> Status:
        """Level and sentence: what is measured, whether the model parts from it, whether the machine keeps up."""
        if self._following is None:
            return Status(self.NAME, Level.OK, self._making)
        intake = self._following.intake
        values = {f"samples_{kind.replace(' ', '_')}": str(count) for kind, count in intake.troubles.items()}
        values |= {} if self._found is None else values_for_diagnostics(self._found)
        values |= {**self.samples.values(), **self._channels.values(), "windows_waiting": str(len(intake.ready))}
        level, silence = self.samples.verdict()
        lacks = "" if self.samples.rests else self._channels.verdict()[1]
        frozen = f"{', '.join(sorted(intake.frozen))}: frozen, left out" if intake.frozen else ""
        slow = "too slow for real time, windows are left out; take fewer members or a coarser mesh"
        return self.status(
            values,
            (level, silence if level is not Level.OK else ""),
            trust_in(self._found) if self._found is not None else (Level.OK, ""),
            (Level.WARN, lacks or self.topics.loss or frozen or intake.drive.told),
            (Level.WARN, slow if intake.troubles["skipped window"] else ""),
            verdict_of(self._found) if self._found is not None else (Level.OK, silence),
            (Level.OK, "waiting for the end of the first window"),
        )
