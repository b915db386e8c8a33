# SPDX-License-Identifier: Apache-2.0
"""Layouts for RViz, Foxglove and PlotJuggler refer to topics, types, joints and fields of a recorded run.

`test_foxglove.py` holds them against the topics of a running one.
"""

import pytest
from rclpy.serialization import deserialize_message
from view_layouts import check_foxglove, check_plotjuggler, check_rviz

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import OF_EVERY_RUN, TOPICS
from drill_twin.ros.core.topics import message_class


@pytest.fixture(scope="module")
def messages(small_bag):
    """The last message of each topic of a run of the paper's scene."""
    bag = Bag(small_bag)
    return {topic: deserialize_message(bag.last(topic), message_class(TOPICS[topic])) for topic in OF_EVERY_RUN}


@pytest.mark.parametrize("check", [check_rviz, check_foxglove, check_plotjuggler])
def test_a_layout_shows_what_a_recording_has(check, messages):
    check(messages)
