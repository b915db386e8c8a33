# SPDX-License-Identifier: Apache-2.0
"""Recorder node: writes every topic of the contract, byte for byte, to an MCAP bag that survives kill -9."""

import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from rclpy.subscription import Subscription

from drill_twin.core.errors import BagError, ParameterError, RunError
from drill_twin.io.bag.metadata import RecordedTopic, contract_topic
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import DIAGNOSTICS, OF_TF, TOPICS, sub_of
from drill_twin.ros.core.graph import unlisted
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import ALL_TOPICS, Rights
from drill_twin.ros.core.topics import installed

_DEPTH = 2000  # messages of one topic; 10 s at 200 Hz
_QUIET, _LONGEST = 0.3, 1.5  # s
_NOT_AT_A_RATE = {
    DIAGNOSTICS,
    *OF_TF,
    *(name for name, topic in TOPICS.items() if topic.latched or topic.rate == "on change"),
}
_SEARCH_PERIOD = 0.5  # s; topics of downhole subs appear during a run
_BATCH_TIME = 0.01  # s; waking up for each message would cost as much as writing it


class Recorder(TwinNode):
    """Writes the messages of all topics to a bag, and counts the messages it missed."""

    NAME = "recorder"
    PURPOSE = "Records every topic of the twin to an MCAP bag."
    PARAMETERS = (
        Parameter("bag", "", 'new folder of the bag, best ending in _0; "": bags/<date>_<time>_0 here'),
        Parameter("max_bagfile_size", 0.0, "a file of this size is followed by another; 0: one file", "MB", 0.0, 1e6),
        Parameter(
            "max_bagfile_duration", 0.0, "a file of this length is followed by another; 0: one file", "s", 0.0, 1e6
        ),
        Parameter(
            "topics",
            (),
            "topics to record; none: all of the contract, and tf where tf2_msgs is installed",
            such_as='["/rig/state", "/marks/state"]',
        ),
        Parameter(
            "regex", "", "also topics in whose full name this regular expression is found", such_as="/rig/|/marks/"
        ),
        Parameter("exclude_topics", (), "topics not to record", such_as='["/string/markers"]'),
        Parameter(
            "exclude_regex",
            "",
            "regular expression of topics not to record",
            such_as="/string/.*",
        ),
        AUTOSTART,
    )
    RIGHTS = Rights(subscribes=tuple(ALL_TOPICS))
    _bag: BagWriter
    """The bag; made by `configure`."""

    def configure(self) -> None:
        """Create the bag, the subscriptions, and a timer that looks for topics of subs."""
        self._namespace = self.get_namespace().rstrip("/")
        self._told = 0  # sentences on changes of the bag by other programs
        self._failure = ""  # a bag that failed once is not written to again, so that the first error is reported
        self._arrived: list[tuple[str, int, bytes]] = []  # messages that are not in the bag yet
        topics = self._chosen()
        self._bag = BagWriter(
            self.settings.bag or _new_folder(),
            topics=[self._described(topic) for topic in topics],
            custom_data={"namespace": self._namespace} if self._namespace else None,
            largest=self.settings.max_bagfile_size * 1e6,
            longest=self.settings.max_bagfile_duration,
        )
        self._inputs: list[Subscription] = []
        self._recorded = set[str]()
        for topic in topics:
            self._record(topic)
        if at_a_rate := [topic for topic in topics if topic not in _NOT_AT_A_RATE]:
            self.samples.expect(*at_a_rate)
        self.every(_SEARCH_PERIOD, self._record_subs)
        self.get_logger().info(f"recording {len(topics)} topics to {self._bag.folder}")

    def _chosen(self) -> list[str]:
        """Topics to record from the start; topics of subs come once they are there."""
        settings = self.settings
        named, excluded = settings.topics, settings.exclude_topics
        for name, topics in (("topics", named), ("exclude_topics", excluded)):
            if unknown := [topic for topic in topics if topic not in TOPICS]:
                raise ParameterError(
                    f"parameter {name}: expected topics of {', '.join(TOPICS)}, found {', '.join(unknown)}"
                )
        if missing := [topic for topic in named if not installed(topic)]:
            raise ParameterError(
                f"parameter topics: expected topics whose messages are installed, found {', '.join(missing)} of "
                f"{TOPICS[missing[0]].type_name}; install the package of this type"
            )
        also, but = _pattern("regex", settings.regex), _pattern("exclude_regex", settings.exclude_regex)

        def takes(topic: str) -> bool:
            name = self._recorded_name(topic)
            listed = topic in named or bool(also and also.search(name)) or not (named or also)
            return listed and topic not in excluded and not (but and but.search(name))

        self._takes = takes
        known = dict.fromkeys((*named, *TOPICS, *OF_TF))
        if chosen := [topic for topic in known if takes(topic) and installed(topic)]:
            return chosen
        raise ParameterError(
            f"parameters topics, regex, exclude_topics and exclude_regex: expected topics of {', '.join(TOPICS)}, "
            "found none that all four let pass"
        )

    def _record_subs(self) -> None:
        """Record the topics of downhole subs that have appeared in the namespace of this node."""
        for topic in unlisted(self):
            if sub_of(topic) and topic not in self._recorded and self._takes(topic):
                with self._writing():
                    self._bag.add_topic(self._described(topic))
                self._record(topic)

    def _record(self, topic: str) -> None:
        take = partial(self._take, topic, self._recorded_name(topic))
        self._inputs.append(self.topics.subscribe_raw(topic, take, depth=_DEPTH))
        self._recorded.add(topic)

    def _described(self, topic: str) -> RecordedTopic:
        """Topic in the namespace of this node; a renaming of one topic is not recorded, so that it is found."""
        return replace(contract_topic(topic), name=self._recorded_name(topic))

    def _recorded_name(self, topic: str) -> str:
        return topic if topic == DIAGNOSTICS else self._namespace + topic

    def _take(self, topic: str, name: str, raw: bytes, info: Mapping[str, Any]) -> None:
        if self._failure:
            return
        self._arrived.append((name, info["received_timestamp"], raw))
        if topic not in _NOT_AT_A_RATE:
            self.samples.take(topic)

    def _write(self) -> None:
        """Write what has arrived."""
        arrived, self._arrived = self._arrived, []
        with self._writing():
            self._bag.write_all(arrived)
            self._bag.flush_if_due()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn an error of the file into an error that ends the run: the input was valid."""
        self.stop.held = True
        try:
            yield
        except BagError as error:
            self._failure = str(error)
            raise RunError(str(error)) from error
        finally:
            self.stop.held = False

    def step(self) -> None:
        """Record many messages at a time, by the times at which DDS received them; flush the bag also when idle."""
        time.sleep(_BATCH_TIME)
        self.spin_all()
        self._write()
        for text in self._bag.damage[self._told :]:
            self.get_logger().error(f"{text}; going on in {self._bag.file}")
        self._told = len(self._bag.damage)

    def complete(self) -> None:
        """Record what is still arriving, and finish the bag.

        Raises:
            RunError: The bag could not be written, or lacks messages; the exit code tells it.
        """
        if not hasattr(self, "_bag"):
            return
        bag = self._bag
        try:
            if not self._failure:
                self.drain(_QUIET, _LONGEST)
                self._write()
                self.publish_diagnostics()
                with self._writing():
                    bag.close()
        finally:
            if self._failure:
                self.publish_diagnostics()
            lost = [f"{number} of {topic}" for topic, number in self.topics.drops.dropped.items()]
            if bag.lost or self._failure:
                lost.append(f"{bag.lost} in the bag{' and all that came after' * bool(self._failure)}")
            log = self.get_logger().warning if lost else self.get_logger().info
            count = sum(bag.counts.values()) - bag.lost
            log(f"{bag.folder}: {count} messages recorded, lost: {', '.join(lost) or 'none'}")
        if lost and not self._failure:
            raise RunError(
                f"{bag.folder}: expected every message in the bag, lost {', '.join(lost)}; record fewer topics"
            )

    def not_ready(self) -> str:
        """Publishers of its topics that it is not connected to yet, in a sentence; empty when there are none."""
        self._record_subs()
        late = [
            subscription.topic_name
            for subscription in self._inputs
            if subscription.get_publisher_count() < self.count_publishers(subscription.topic_name)
        ]
        return f"not yet connected to the publishers of {', '.join(late)}" if late else ""

    def health(self) -> Status:
        """Messages recorded and lost."""
        bag = self._bag
        lost = sum(self.topics.drops.dropped.values()) + bag.lost
        values = {
            "bag": str(bag.folder),
            "messages": str(sum(bag.counts.values()) - bag.lost),
            "files": str(bag.files),
            "lost": str(lost),
            **{f"lost {topic}": str(number) for topic, number in self.topics.drops.dropped.items()},
            **self.samples.values(),
        }
        level, text = self.samples.verdict()
        return self.status(
            values,
            (Level.ERROR, self._failure or "".join(bag.damage[-1:])),
            (Level.WARN, f"{lost} messages were lost" if lost else ""),
            (level, f"{values['messages']} messages recorded{text and f'; {text}'}"),
        )


def _new_folder() -> str:
    """Folder named by date and time, with the first number of which there is no folder yet."""
    stem = time.strftime("bags/%Y%m%d_%H%M%S_")
    return next(f"{stem}{number}" for number in count() if not Path(f"{stem}{number}").exists())


def _pattern(parameter: str, text: str) -> re.Pattern[str] | None:
    """Regular expression of a parameter; None without one."""
    try:
        return re.compile(text) if text else None
    except re.error as error:
        raise ParameterError(f'parameter {parameter}: expected a regular expression, found "{text}": {error}') from None
