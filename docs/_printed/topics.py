# SPDX-License-Identifier: Apache-2.0
"""Topics of the contract: type, publisher, rate, content with units; quality of service, stamp and frame."""

from drill_twin.cli.ros import rig_table, topic_table


def topics() -> str:
    """Table of the contract."""
    return topic_table().markdown()


def topics_quality() -> str:
    """Quality of service, stamps and frames."""
    return rig_table().markdown()
