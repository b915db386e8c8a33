# SPDX-License-Identifier: Apache-2.0
"""QoS profiles of the publishers in a bag, as other tools wrote them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin.io.bag.metadata import Qos

_LARGEST = 20_000  # characters; a profile has 400


@lru_cache(maxsize=64)
def qos_profiles(text: str) -> tuple[Qos, ...]:
    """QoS profiles in the format of version 9; empty where another tool wrote another format."""
    try:
        content: Any = _content(text)
        return tuple(dict(profile) for profile in dump_qos_v9(parse_qos(content)))
    except (YamlError, ReaderError, KeyError, TypeError, AttributeError, ValueError):
        return ()


def _content(text: str) -> Any:
    if len(text) > _LARGEST:
        raise YamlError(f"QoS profiles: expected a text of at most {_LARGEST} characters, found {len(text)}")
    return plain_yaml(text, "QoS profiles")
