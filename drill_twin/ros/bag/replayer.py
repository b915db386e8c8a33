# SPDX-License-Identifier: Apache-2.0
"""Replayer node: publishes the messages of a bag, byte for byte, with `/clock`, as rosbag2's player does."""

import time
from collections.abc import Iterator
from types import SimpleNamespace

from drill_twin.core.errors import MessageError, ParameterError
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.messages.cdr import ClockTemplate
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, TF_STATIC, TOPICS, TWIN_SCENE
from drill_twin.io.messages.type_store import deserialize
from drill_twin.ros.bag.player_control import SERVICES, PlayerControl, Playhead, offer
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import ALL_TOPICS, READY, Rights
from drill_twin.ros.core.startup_barrier import StartupBarrier, unmatched_readers
from drill_twin.ros.core.topics import installed

_DISCOVERY = 0.6  # s; longest discovery of a running node
_LONGEST_WAIT = 0.05  # s
_DAY = 86400.0  # s
_LONGEST = 365.0 * _DAY
"""Length of a recording [s]; a message later than that has a damaged time, for which a replay would wait."""
_FOR_OTHERS = 0.002  # s between two groups of messages; some 20 callbacks
_ACKNOWLEDGE = 50  # messages; of a burst so short the transport drops none, not even of a topic that keeps one


class Replayer(TwinNode):
    """Publishes the messages of a bag at the times at which they were recorded."""

    NAME = "replayer"
    PURPOSE = "Publishes a bag again, with /clock, at any rate."
    PARAMETERS = (
        Parameter("bag", "", "bag to replay: a folder, or a .mcap or .db3 file"),
        Parameter(
            "rate",
            1.0,
            "replay this many times as fast as recorded; 0: as fast as the readers take it",
            "",
            0.0,
            1000.0,
            live=True,
        ),
        Parameter(
            "start_offset",
            0.0,
            "place in the bag where the replay begins, also after a loop; a change moves the replay there",
            "s",
            0.0,
            _LONGEST,
            live=True,
        ),
        Parameter("start_paused", False, "whether the replay begins paused, for ~/play_next or ~/resume"),
        Parameter(
            "topics",
            (),
            "topics to replay; none: all of the contract that the bag holds but /diagnostics, which would be "
            "mixed with what the running nodes say",
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
        Parameter("wait_timeout", 30.0, "longest wait for nodes", "s", 0.0, 3600.0),
        Parameter("loop", False, "whether to begin again at the end"),
        AUTOSTART,
    )
    RIGHTS = Rights(publishes=tuple(ALL_TOPICS), services=tuple(f"~/{name}" for name in SERVICES), calls=READY)
    _sent = 0
    _skipped = SkippedMessages()

    def configure(self) -> None:
        """Open the bag and create its publishers and services."""
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
        length = self._passed(self._bag.end)
        self.get_logger().info(f"{settings.bag}: {self._bag.message_count} messages in {length:.1f} s")
        self._head = Playhead(0.0, settings.rate, paused=settings.start_paused)
        self._control = PlayerControl(self._head, self._bag.start, length, self)
        self._offset = settings.start_offset
        self._control.go_to(self._offset)
        offer(self, self._control)
        self._waits, self._again, self._steps = True, 0, self._replay()

    def activate(self) -> None:
        """Go on where the replay rested."""
        self._head.change(waits=self._waits)

    def deactivate(self) -> None:
        """Let the replay rest."""
        self._head.change(waits=True)

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse a start outside the bag."""
        if self.configured:
            self._control.check(settings.start_offset)

    def on_change(self) -> None:
        """Go on at another rate, or from another place."""
        self._head.change(rate=self.settings.rate)
        if self._offset != self.settings.start_offset:
            self._offset = self.settings.start_offset
            self._control.go_to(self._offset)

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
        chosen = [name for name in held if name in (wanted or {*held} - {DIAGNOSTICS}) and name not in unwanted]
        if missing := [name for name in chosen if not installed(name)]:
            self.get_logger().warning(f"left out, as their message package is not installed: {', '.join(missing)}")
        chosen = [name for name in chosen if name not in missing]
        if not chosen:
            raise ParameterError(
                f"parameters topics and leave_out: expected them to leave a topic of the bag, {', '.join(held)}, "
                f'found topics "{" ".join(wanted)}" and leave_out "{" ".join(unwanted)}"'
            )
        return chosen

    def step(self) -> None:
        """Publish the messages that are due, or wait for at most 50 ms."""
        if wait := next(self._steps, _LONGEST_WAIT):
            self.spin_once(wait)
        else:  # requests are answered also where messages come as fast as they go
            end = time.monotonic() + _FOR_OTHERS
            while time.monotonic() < end:
                self.spin_once(0.0)

    def _replay(self) -> Iterator[float]:
        """Wait for the readers to be connected, then replay; yields the time to wait [s], often."""
        # The scene is published first, before its time: an analyzer is only ready once it knows the marks.
        begin = self._offset
        self._publish_kept(begin)
        yield from self._wait_for_readers(time.monotonic() + _DISCOVERY)
        self._waits = False
        self._head.change(waits=False)
        while self._head.target is not None:
            if self._repeating or self._head.target != begin:
                self._publish_kept(self._head.target)
                self.flush(1.0)
                yield from self._wait_for_readers(0.0)  # an analyzer may take a while to begin the next run
            yield from self._play(self._head.target)
            self._repeating = True
            if self._head.target is None and self.settings.loop:
                self._head.target = self._offset
        self._over = True

    def _wait_for_readers(self, earliest: float) -> Iterator[float]:
        prefix = f"{self.topics.prefix}/" if self.topics.prefix else ""
        names = " ".join(prefix + name for name in self.settings.wait_for)
        barrier = StartupBarrier(self, names, self.settings.wait_timeout)
        while time.monotonic() < earliest or unmatched_readers(self) or not barrier.passed():
            yield _LONGEST_WAIT

    def _publish_kept(self, place: float) -> None:
        """Publish what holds at the place to go to: the last message before it on each latched topic and of the clock.

        A scene that comes again has another text, with which the analyzer begins a new run.
        """
        kept: dict[tuple[str, bytes], bytes] = {}
        self._early, scene = b"", (TWIN_SCENE, b"")
        kept_topics = [name for name in self._topics if TOPICS[name].latched or name == CLOCK_TOPIC]
        for topic, stamp, raw in self._bag.messages(kept_topics):
            passed = self._passed(stamp)
            if passed >= place and (scene in kept or TWIN_SCENE not in self._topics):
                break
            if (passed < place or topic == TWIN_SCENE) and self._usable(topic, passed, raw, counted=False):
                kept[topic, raw if topic == TF_STATIC else b""] = raw
                self._early = raw if passed >= place else b""
        if scene in kept and place < self._head.place:
            self._again += 1
            kept[scene] = encode_string(f"{read_string(kept[scene])}# played again: {self._again}\n")
        if self._clock_period and self._repeating:
            kept[CLOCK_TOPIC, b""] = self._clock_message.fill(self._bag.start + round(place * NANOSECONDS))
        for (topic, _), raw in kept.items():
            self.topics.publish(topic, raw)

    def _play(self, begin: float) -> Iterator[float]:
        """Publish the messages from a place on [s], until the end or until the playhead is to go elsewhere."""
        head, clock_due = self._head, begin
        head.target = None
        head.arrive(begin)
        for number, (topic, stamp, raw) in enumerate(self._bag.messages(self._topics)):
            if not number % _ACKNOWLEDGE:
                yield 0.0
            passed = self._passed(stamp)
            if topic == TWIN_SCENE and raw == self._early:
                self._early = b""
                continue
            if passed < begin:
                head.arrive(begin)
            if passed < begin or not self._usable(topic, passed, raw):
                continue
            while (wait := head.time_to(passed)) and head.target is None:
                yield min(wait, _LONGEST_WAIT)
            if head.target is not None:
                return
            if self._clock_period and passed >= clock_due:
                self.topics.publish(CLOCK_TOPIC, self._clock_message.fill(stamp))
                clock_due = passed + self._clock_period * (self.settings.rate or 1.0)
            self.topics.publish(topic, raw)
            head.passed(passed)
            self._sent += 1
            if not self.settings.rate and not self._sent % _ACKNOWLEDGE:
                self.flush(1.0)

    def _passed(self, stamp: int) -> float:
        """Time from the start of the bag to a time of recording [ns], in s."""
        return (stamp - self._bag.start) / NANOSECONDS

    def _usable(self, topic: str, passed: float, raw: bytes, *, counted: bool = True) -> bool:
        """Check a message; a message that no node could use is left out and counted, once a bag."""
        try:
            if passed > _LONGEST:
                raise MessageError(f"recorded {passed / _DAY:.0f} days after the first message")
            deserialize(raw, TOPICS[topic].type_name)
        except MessageError as error:
            if counted and not self._repeating:
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
        left_out, head = len(self._skipped), self._head
        values = {"bag": self.settings.bag, "rate": f"{self.settings.rate:g}", "messages": str(self._sent)}
        values |= {"left_out": str(left_out), "place": f"{head.place:.3f}", "paused": str(head.paused).lower()}
        if self.active and (head.paused or head.waits):  # silence is then no fault
            values["state"] = "paused" if head.paused else "waiting"
        trouble = f"{left_out} messages left out" if left_out else ""
        progress = f"{self._sent} of {self._bag.message_count} messages replayed"
        return self.status(values, (Level.WARN, trouble), (Level.OK, progress))
