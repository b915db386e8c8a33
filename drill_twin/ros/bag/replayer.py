# SPDX-License-Identifier: Apache-2.0
"""Replayer node: publishes the messages of a bag, byte for byte, with `/clock`, at any rate."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import ClassVar

from drill_twin.core.errors import MessageError
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.messages.cdr import ClockTemplate
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, TOPICS, TWIN_SCENE
from drill_twin.io.messages.type_store import deserialize
from drill_twin.ros.core.given import ParameterError
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import ALL_TOPICS, READY, Rights
from drill_twin.ros.core.startup_barrier import StartupBarrier, unmatched_readers

_DISCOVERY = 0.6  # s; longest discovery of a running node
_LONGEST_WAIT = 0.05  # s
_DAY = 86400.0  # s
_LONGEST = 365.0 * _DAY
"""Length of a recording [s]; a message later than that has a damaged time, for which a replay would wait."""
_ACKNOWLEDGE = 50  # messages; half of what a publisher keeps


class Replayer(TwinNode):
    """Publishes the messages of a bag at the times at which they were recorded."""

    NAME: ClassVar = "replayer"
    PURPOSE: ClassVar = "Publishes a bag again, with /clock, at any rate."
    PARAMETERS: ClassVar = (
        Parameter("bag", "", "bag to replay: a folder, or a .mcap or .db3 file"),
        Parameter(
            "rate",
            1.0,
            "replay this many times as fast as recorded; 0: as fast as the readers take it",
            "",
            0.0,
            1000.0,
        ),
        Parameter(
            "topics",
            (),
            "topics to replay; none: all of the contract that the bag holds",
            such_as='["/rig/state", "/marks/state"]',
        ),
        Parameter(
            "map",
            (),
            "topics of the bag that have other names than ours",
            such_as='["/camera/marks=/marks/state"]',
        ),
        Parameter("twin", "", 'namespace of the twin in the bag, as /rig2, where it holds several; "": the only one'),
        Parameter(
            "keep_namespace",
            True,
            "whether to publish in the namespace that was recorded, if this node has none of its own; else in its own",
        ),
        Parameter(
            "leave_out",
            (),
            "topics not to replay; for a new analysis the findings",
            such_as='["/whirl/state", "/whirl/motion", "/whirl/onset", "/twin/summary"]',
        ),
        Parameter(
            "clock_rate", 40.0, "/clock of a bag that holds none, per second of wall time; 0: none", "Hz", 0.0, 1000.0
        ),
        Parameter("wait_for", (), "nodes that must be ready before the first message"),
        Parameter("wait_timeout", 30.0, "longest wait for them", "s", 0.0, 3600.0),
        Parameter("loop", False, "whether to begin again at the end"),
        AUTOSTART,
    )
    RIGHTS: ClassVar = Rights(publishes=tuple(ALL_TOPICS), calls=READY)
    _sent = 0
    _skipped = SkippedMessages()

    def configure(self) -> None:
        """Open the bag and create its publishers."""
        from drill_twin.io.bag.reader import Bag, parse_remappings

        settings = self.settings
        self._over = self._repeating = False
        self._skipped = SkippedMessages()
        if not settings.bag:
            raise ParameterError("parameter bag: expected the path of a bag, found none; add -p bag:=PATH")
        names = parse_remappings(settings.map, "parameter map")
        self._bag = Bag(settings.bag, names=names, namespace=settings.twin or None)
        if settings.keep_namespace and self.get_namespace() == "/":
            self.topics.prefix = self._bag.namespace
        self._topics = self._chosen()
        for topic in self._topics:
            if topic != DIAGNOSTICS:  # every node has its publisher
                self.topics.advertise(topic)
        self._clock_period = 0.0
        if CLOCK_TOPIC not in self._topics and settings.clock_rate and CLOCK_TOPIC not in settings.leave_out:
            self.topics.advertise(CLOCK_TOPIC)
            self._clock_period = 1.0 / settings.clock_rate
        self._clock_message = ClockTemplate()
        for text in self._bag.damage:
            self.get_logger().warning(text)
        length = (self._bag.end - self._bag.start) * 1e-9
        self.get_logger().info(f"{settings.bag}: {self._bag.message_count} messages in {length:.1f} s")
        self._began = self._rests = 0.0
        self._waits, self._steps = True, self._replay()

    def activate(self) -> None:
        """Go on where the replay rested."""
        self._began += time.monotonic() - self._rests

    def deactivate(self) -> None:
        """Let the replay rest."""
        self._rests = time.monotonic()

    def complete(self) -> None:
        """Wait until the readers have received everything."""
        if self._sent:
            self.flush()
            self.get_logger().info(f"{self._sent} messages replayed")
        for text in self._skipped.sentences():
            self.get_logger().warning(f"left out: {text}")

    def _chosen(self) -> list[str]:
        held = [name for name, topic in self._bag.topics.items() if name in TOPICS and topic.count]
        wanted, unwanted = self.settings.topics, self.settings.leave_out
        for name, values in (("topics", wanted), ("leave_out", unwanted)):
            if unknown := [topic for topic in values if topic not in self._bag.topics and topic not in TOPICS]:
                raise ParameterError(
                    f"parameter {name}: expected topics of the bag, {', '.join(held)}, found {', '.join(unknown)}"
                )
        return [topic for topic in held if (not wanted or topic in wanted) and topic not in unwanted]

    def step(self) -> None:
        """Publish the messages that are due, or wait for at most 50 ms."""
        if wait := next(self._steps, _LONGEST_WAIT):
            self.spin_once(wait)
        else:
            self.spin_all()

    def _replay(self) -> Iterator[float]:
        """Wait for the readers to be connected, then replay; yields the time to wait [s], often."""
        # The scene is published first, before its time: an analyzer is only ready once it knows the marks.
        self._scene_sent = TWIN_SCENE in self._topics
        if self._scene_sent:
            scenes = (raw for _, _, raw in self._bag.messages([TWIN_SCENE]))
            first = next((raw for raw in scenes if self._usable(TWIN_SCENE, 0.0, raw)), None)
            if first is not None:
                self.topics.publish(TWIN_SCENE, first)
        discovered = time.monotonic() + _DISCOVERY
        prefix = f"{self.topics.prefix}/" if self.topics.prefix else ""
        names = " ".join(prefix + name for name in self.settings.wait_for)
        barrier = StartupBarrier(self, names, self.settings.wait_timeout)
        while time.monotonic() < discovered or unmatched_readers(self) or not barrier.passed():
            yield _LONGEST_WAIT
        self._waits = False
        while not self._over:
            self._began, clock_due = time.monotonic(), 0.0
            for number, (topic, stamp, raw) in enumerate(self._bag.messages(self._topics)):
                if not number % _ACKNOWLEDGE:
                    yield 0.0
                if self._scene_sent and topic == TWIN_SCENE:
                    self._scene_sent = False
                    continue
                passed = (stamp - self._bag.start) * 1e-9
                if not self._usable(topic, passed, raw):
                    continue
                if self._clock_period and passed >= clock_due:
                    self.topics.publish(CLOCK_TOPIC, self._clock_message.fill(stamp))
                    clock_due = passed + self._clock_period * (self.settings.rate or 1.0)
                if self.settings.rate:
                    while (left := self._began + passed / self.settings.rate - time.monotonic()) > 0.0:
                        yield min(left, _LONGEST_WAIT)
                self.topics.publish(topic, raw)
                self._sent += 1
                if not self.settings.rate and not self._sent % _ACKNOWLEDGE:
                    self.flush(1.0)
            yield 0.0 if self._topics else _LONGEST_WAIT  # a selection may be empty
            self._over, self._repeating = not self.settings.loop, True

    def _usable(self, topic: str, passed: float, raw: bytes) -> bool:
        """Check a message; a message that no node could use is left out and counted, once a bag."""
        try:
            if passed > _LONGEST:
                raise MessageError(f"recorded {passed / _DAY:.0f} days after the first message")
            deserialize(raw, TOPICS[topic].type_name)
        except MessageError as error:
            if not self._repeating:
                self._skipped.add(topic, passed, error)
            return False
        return True

    @property
    def finished(self) -> bool:
        """True once all has been replayed."""
        return self._over

    def not_ready(self) -> str:
        """Reason why it does not replay yet; empty when it does."""
        return "it waits for other nodes" if self._waits else ""

    def health(self) -> Status:
        """Progress of the replay."""
        values = {"bag": self.settings.bag, "rate": f"{self.settings.rate:g}", "messages": str(self._sent)}
        values["left_out"] = str(len(self._skipped))
        if self._skipped:
            return Status(self.NAME, Level.WARN, f"{len(self._skipped)} messages left out", values)
        return Status(self.NAME, Level.OK, f"{self._sent} of {self._bag.message_count} messages replayed", values)
