# SPDX-License-Identifier: Apache-2.0
"""Content of rosbag2's `metadata.yaml`, version 9, and QoS profiles in its format."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from drill_twin.io.messages.topic_row import Topic
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import definition, type_hash

_FOREVER = {"sec": 9223372036, "nsec": 854775807}

Qos = dict[str, Any]
"""QoS profile as rosbag2 writes it: history, depth, reliability, durability and so on."""


def contract_qos(topic: Topic) -> Qos:
    """QoS profile of a topic of the contract."""
    return {
        "history": "keep_last",
        "depth": topic.depth,
        "reliability": "reliable",
        "durability": "transient_local" if topic.latched else "volatile",
        "deadline": _FOREVER,
        "lifespan": _FOREVER,
        "liveliness": "automatic",
        "liveliness_lease_duration": _FOREVER,
        "avoid_ros_namespace_conventions": False,
    }


def to_yaml(content: Any) -> str:
    """YAML text in block style, without aliases, keys in their order, as rosbag2 writes it."""
    return str(yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=4096))


_SAFE: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # the same text, in C where PyYAML was built with it


class _Dumper(_SAFE):  # type: ignore[misc]
    """Safe dumper without aliases for repeated values."""

    def ignore_aliases(self, data: Any) -> bool:
        del data
        return True


@dataclass
class RecordedTopic:
    """Topic of a bag."""

    name: str
    """Topic name."""
    type_name: str
    """ROS type."""
    definition: str
    """Message definition with the definitions that it depends on; empty where the bag has none."""
    type_hash: str
    """RIHS01 hash; empty where the bag has none."""
    qos: Sequence[Qos] = field(default_factory=list)
    """QoS profiles of its publishers."""
    count: int = 0
    """Number of messages."""


def contract_topic(name: str) -> RecordedTopic:
    """Topic of the contract, without messages."""
    topic = TOPICS[name]
    kind = topic.type_name
    return RecordedTopic(name, kind, definition(kind), type_hash(kind), [contract_qos(topic)])


def bag_information(
    files: Sequence[tuple[str, int, int, int]], topics: Sequence[RecordedTopic], custom_data: Mapping[str, str]
) -> dict[str, Any]:
    """Content of `rosbag2_bagfile_information` for a bag of MCAP files.

    Args:
        files: Name, times of first and last message [ns] and number of messages of each file.
        topics: Topics, with counts over all files.
        custom_data: Texts by key.
    """
    times_of_all = [(start, end) for _, start, end, count in files if count] or [(0, 0)]

    def times(start: int, end: int) -> dict[str, Any]:
        return {"starting_time": {"nanoseconds_since_epoch": start}, "duration": {"nanoseconds": max(end - start, 0)}}

    return {
        "version": 9,
        "storage_identifier": "mcap",
        "relative_file_paths": [name for name, *_ in files],
        **times(min(start for start, _ in times_of_all), max(end for _, end in times_of_all)),
        "message_count": sum(topic.count for topic in topics),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": list(topic.qos),
                    "type_description_hash": topic.type_hash,
                },
                "message_count": topic.count,
            }
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "files": [{"path": name, **times(start, end), "message_count": count} for name, start, end, count in files],
        "custom_data": dict(custom_data) or None,
        "ros_distro": "jazzy",
    }
