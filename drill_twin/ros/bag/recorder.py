# SPDX-License-Identifier: Apache-2.0
"""The recorder: every topic of the contract, byte for byte, into an MCAP bag that survives kill -9."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, ClassVar

from rclpy.context import Context

from drill_twin.errors import BagError, RunError
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import TOPICS
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import run_node
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.parameters import Parameter, ParameterError, Value
from drill_twin.ros.entry_points import StopRequest

_DEPTH = 2000  # messages of one topic; 10 s at 200 Hz
_QUIET = 0.3  # s
_GATHER = 0.01  # s; waking up for each message would cost as much as writing it


class Recorder(TwinNode):
    """Writes what it receives, counts what it does not."""

    NAME: ClassVar = "recorder"
    PURPOSE: ClassVar = "Records every topic of the twin to an MCAP bag."
    PARAMETERS: ClassVar = (
        Parameter("bag", "", 'new folder of the bag, best ending in _0; "": bags/<date>_<time>_0 here'),
        Parameter("max_bagfile_size", 0.0, "a file of this size is followed by another; 0: one file", "MB", 0.0, 1e6),
        Parameter(
            "max_bagfile_duration", 0.0, "a file of this length is followed by another; 0: one file", "s", 0.0, 1e6
        ),
        Parameter(
            "topics",
            "",
            'topics to record, separated by spaces; "": all of the contract',
            such_as="/rig/state /marks/state",
        ),
    )

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, also_known: Sequence[str] = ()
    ) -> None:
        super().__init__(context, values, also_known)
        self._bag: BagWriter | None = None
        self._look = Tick(1.0)
        self._broken = False  # a bag that failed once takes no more, so that the first error is the one told

    def open(self) -> None:
        """Create the bag and subscribe."""
        topics = self.settings.topics.split() or list(TOPICS)
        if unknown := [topic for topic in topics if topic not in TOPICS]:
            raise ParameterError(
                f"parameter topics: expected topics of {', '.join(TOPICS)}, found {', '.join(unknown)}"
            )
        self._bag = BagWriter(
            self.settings.bag or time.strftime("bags/%Y%m%d_%H%M%S_0"),
            topics=topics,
            largest=self.settings.max_bagfile_size * 1e6,
            longest=self.settings.max_bagfile_duration,
        )
        self._inputs = [self.listen(topic, self._writer_of(topic), depth=_DEPTH) for topic in topics]
        self.get_logger().info(f"recording {len(topics)} topics to {self._bag.folder}")

    def _writer_of(self, topic: str) -> Any:
        bag = self._bag

        def write(raw: bytes, info: Mapping[str, Any]) -> None:
            if self._broken:
                return
            with self._writing():
                bag.write(topic, info["received_timestamp"], raw)

        return write

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """What goes wrong with the file in mid-run ends the run; it is no bad input."""
        try:
            yield
        except BagError as error:
            self._broken = True
            raise RunError(str(error)) from error

    def work(self) -> None:
        """Record what comes, many messages at a time: DDS has noted when each came. An idle bag is flushed too."""
        self.listen_for(0.05)
        time.sleep(_GATHER)
        with self._writing():
            self._bag.flush_if_due()
        if self._look.due():
            self._refuse_removed()

    def _refuse_removed(self) -> None:
        """A file without a name can be written to, and is lost; so it is looked for."""
        if not self._bag.file.exists():
            self._broken = True
            raise RunError(f"{self._bag.file}: expected the bag that is being recorded, found it removed; record again")

    def close(self) -> None:
        """Record what is still coming, and finish the bag."""
        if self._bag is None:
            return
        try:
            if not self._broken:
                self.settle(_QUIET)
                self.report_health()
                self._refuse_removed()
        finally:
            if self._bag.file.exists():
                self._bag.close()
        count = sum(self._bag.counts.values())
        lost = ", ".join(f"{number} of {topic}" for topic, number in self.dropped.items())
        say = self.get_logger().warning if lost else self.get_logger().info
        say(f"{self._bag.folder}: {count} messages recorded, lost: {lost or 'none'}")

    def not_ready(self) -> str:
        """Why it would miss something that is published now; empty when it would not."""
        late = [
            subscription.topic_name
            for subscription in self._inputs
            if subscription.get_publisher_count() < self.count_publishers(subscription.topic_name)
        ]
        return f"not yet connected to the publishers of {', '.join(late)}" if late else ""

    def health(self) -> Status:
        """Messages recorded and lost."""
        counts = self._bag.counts if self._bag else {}
        lost = sum(self.dropped.values())
        values = {
            "bag": str(self._bag.folder) if self._bag else "",
            "messages": str(sum(counts.values())),
            "files": str(self._bag.files if self._bag else 0),
            "lost": str(lost),
            **{f"lost {topic}": str(number) for topic, number in self.dropped.items()},
        }
        if lost:
            return Status(self.NAME, Level.WARN, f"{lost} messages were lost", values)
        return Status(self.NAME, Level.OK, f"{values['messages']} messages recorded", values)


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run the recorder."""
    run_node(Recorder, arguments, stop)
