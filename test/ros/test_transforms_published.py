# SPDX-License-Identifier: Apache-2.0
"""tf of a running twin, where tf2_msgs is installed; without it the simulator runs as well."""

import pytest

from drill_twin.io.messages.topics import TF, TOPICS
from drill_twin.ros.core.topics import installed, message_class


def test_tf_is_published_where_its_messages_are_installed(bench):
    if not installed(TF):
        pytest.skip("needs tf2_msgs, which is in ROS 2 but not in the wheels")
    heard = []
    bench.node.create_subscription(message_class(TOPICS[TF]), "/tf", heard.append, 10)
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until(lambda: len(heard) > 5, what="/tf")
    assert next(one.child_frame_id for one in heard[-1].transforms) == "bit"
    assert simulator.end() == 0, simulator.text
