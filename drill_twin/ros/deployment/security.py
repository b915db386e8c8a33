# SPDX-License-Identifier: Apache-2.0
"""Refusal to start without the required security (SROS2).

The Fast DDS of the wheels is built without security plugins; with a whole ROS 2 Jazzy they are there.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from drill_twin.core.errors import DrillTwinError


def refuse_unsecured() -> None:
    """Refuse to start if `ROS_SECURITY_STRATEGY=Enforce` is set but would have no effect.

    Raises:
        DrillTwinError: ROS 2 would start without security, or has no keys.
    """
    if os.environ.get("ROS_SECURITY_STRATEGY", "").lower() != "enforce":
        return
    enabled, keys = os.environ.get("ROS_SECURITY_ENABLE", ""), os.environ.get("ROS_SECURITY_KEYSTORE", "")
    if enabled.lower() != "true":
        raise DrillTwinError(
            "ROS_SECURITY_STRATEGY=Enforce: expected ROS_SECURITY_ENABLE=true beside it, found "
            f"{enabled or 'none'}, with which ROS 2 would start unsecured; set it, or unset ROS_SECURITY_STRATEGY"
        )
    if not os.path.isdir(keys):  # noqa: PTH112 - a path of the environment, used once
        raise DrillTwinError(
            f"ROS_SECURITY_STRATEGY=Enforce: expected the folder of the keys in ROS_SECURITY_KEYSTORE, found "
            f"{keys or 'none'}; make one with ros2 security create_keystore"
        )


@contextmanager
def readable_refusal() -> Iterator[None]:
    """Turn the errors with which rclpy refuses to create a node into one line.

    Raises:
        DrillTwinError: rclpy refused to create it.
    """
    try:
        yield
    except RuntimeError as error:  # rclpy's RCLError is one
        text = " ".join(str(error).partition(", at ")[0].split())
        if "security" not in text:
            raise DrillTwinError(f"expected ROS to make this node, found: {text}") from error
        raise DrillTwinError(
            f"expected a Fast DDS with security, found: {text.removeprefix('error creating node: ')}; that of the "
            "wheels has none: use a whole ROS 2 Jazzy, or unset ROS_SECURITY_ENABLE to run unsecured"
        ) from error
