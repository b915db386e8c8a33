# SPDX-License-Identifier: Apache-2.0
"""Nodes from their arguments to their end: started with our defaults, ended in order whatever happens."""

from __future__ import annotations

import re
from collections.abc import Sequence

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from drill_twin.errors import DrillTwinError
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.parameters import Parameter, file_text, help_text
from drill_twin.ros.core.qos_overrides import refuse_unused
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment import discovery
from drill_twin.ros.deployment.security import readable_refusal


def run_node(make: type[TwinNode], arguments: Sequence[str], stop: StopRequest) -> None:
    """Start one node, run it, and end it in order whatever happens.

    Raises:
        DrillTwinError: It refused to start or could not go on.
    """
    if asks_for_help(make.NAME, make.PURPOSE, make.PARAMETERS, arguments):
        return
    context = initialised(arguments, stop)
    try:
        with stop.at_once(), readable_refusal():
            node = make(context)
        run_in_order(node, stop)
    finally:
        context.try_shutdown()


def initialised(arguments: Sequence[str], stop: StopRequest) -> Context:
    """An rclpy context for these arguments, with our discovery defaults and without rclpy's signal handlers.

    Raises:
        DrillTwinError: The arguments are none that ROS knows.
    """
    _refuse_misplaced(arguments)
    discovery.prepare()
    context = Context()
    try:
        with stop.at_once():
            rclpy.init(args=list(arguments), context=context, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy raises several classes of its own here, and RuntimeError
        said = _first_line(error)
        hint = "" if ".yaml" in said else "; write -p NAME:=VALUE, -r FROM:=TO or --params-file FILE.yaml"
        raise DrillTwinError(f"ROS arguments: {said}{hint}") from error
    if left := remove_ros_args(["", *arguments])[1:]:
        context.try_shutdown()
        raise DrillTwinError(f"expected only --help or --ros-args ..., found {' '.join(left)!r}")
    return context


def _refuse_misplaced(arguments: Sequence[str]) -> None:
    """Without --ros-args, ROS takes NAME:=VALUE for a renaming; the parameter that was meant would keep its default."""
    of_ros = False
    for word, before in zip(arguments, ["", *arguments], strict=False):
        of_ros = word == "--ros-args" or (of_ros and word != "--")
        if ":=" in word and not (of_ros and before.startswith("-") and before != "--ros-args"):
            remedy = "-p" if of_ros else "--ros-args -p"
            raise DrillTwinError(
                f"expected -p NAME:=VALUE or -r FROM:=TO after --ros-args, found {word!r}; write {remedy} {word}"
            )


def run_in_order(node: TwinNode, stop: StopRequest) -> None:
    """Open, run and close a node; destroys it."""
    try:
        with stop.at_once():
            node.open()
            if not node.topics_pending and not node.shares_parameters:
                refuse_unused(node)
        node.run(stop)
    finally:
        try:
            node.close()
        finally:
            node.destroy_node()


def asks_for_help(name: str, purpose: str, table: Sequence[Parameter], arguments: Sequence[str]) -> bool:
    """Whether --help was given, or --parameters for the node's parameter file; prints it."""
    if {"-h", "--help"} & set(arguments):
        print(help_text(name, purpose, table))
    elif list(arguments) == ["--parameters"]:
        print(file_text(name, purpose, table), end="")
    else:
        return False
    return True


def _first_line(error: BaseException) -> str:
    text = str(error).strip()
    line = text.splitlines()[0] if text else type(error).__name__
    return re.sub(r", at [^,\s]+:\d+", "", line).removeprefix("failed to initialize rcl: ")
