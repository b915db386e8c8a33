# SPDX-License-Identifier: Apache-2.0
"""Topics of the contract: type, publisher, rate, content with units; quality of service, stamp and frame."""

from drill_twin.core.table import Table
from drill_twin.io.messages.topic_row import FLOAT64, IMU, STRING
from drill_twin.io.messages.topics import CLOCK_TOPIC, FRAME_ID, OF_SUBS, RIG_COMMAND, TOPICS


def topics() -> str:
    """Table of the contract."""
    rows = [
        (
            f"`{topic.name}`", topic.type_name.replace("/msg/", "/"), topic.publisher,
            f"{topic.rate}, latched" if topic.latched else topic.rate, topic.meaning,
        )
        for topic in (*TOPICS.values(), *OF_SUBS)
    ]  # fmt: skip
    return Table(("topic", "type", "who", "when", "meaning"), rows).markdown()


def topics_quality() -> str:
    """Table for rig software: publisher, quality of service, stamp and frame."""
    own = {CLOCK_TOPIC: "simulated time", RIG_COMMAND: "simulated time, the commander's name"}
    rows = []
    for topic in (*TOPICS.values(), *OF_SUBS):
        latched = ", latched" if topic.offered_latched else ""
        stamp = own.get(topic.name, f"simulated time, `{FRAME_ID}`")
        if topic.type_name in (FLOAT64, STRING):
            stamp = "none"
        elif topic.type_name == IMU:
            stamp = "time of the measurement, name of the sub"
        elif topic.publisher == "all nodes":
            stamp = "wall time"
        depth = f"reliable, keep last {topic.publisher_depth}{latched}"
        rows.append((f"`{topic.name}`", topic.type_name, topic.publisher, topic.rate, depth, stamp))
    return Table(("topic", "type", "from", "rate", "quality of service", "stamp and frame"), rows).markdown()
