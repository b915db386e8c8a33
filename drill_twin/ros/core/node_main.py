# SPDX-License-Identifier: Apache-2.0
"""Start, run and end of a node: from its arguments to an orderly shutdown after any error."""

import re
from collections.abc import Iterable, Sequence

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from drill_twin.core.errors import DrillTwinError
from drill_twin.ros.core.given import ArgumentsContext, warn_of_misspelled
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.parameters import Parameter, file_text
from drill_twin.ros.core.policy import policy_text
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment import prepare, readable_refusal


def run_node(kind: type[TwinNode], arguments: Sequence[str], stop: StopRequest, parameters: Iterable[str]) -> None:
    """Start one node, run it, and shut it down in order, also after an error.

    Args:
        kind: Class of the node.
        arguments: Its arguments.
        stop: Request to stop.
        parameters: Names of the parameters of all nodes, read only where a parameter was given to all.

    Raises:
        DrillTwinError: The node refused to start or could not go on.
    """
    if print_help(kind.NAME, kind.PURPOSE, kind.PARAMETERS, arguments):
        return
    if list(arguments) == ["--policy"]:
        print(policy_text(kind.NAME, kind.RIGHTS), end="")
        return
    context = init_context(arguments, stop)
    try:
        with stop.at_once(), readable_refusal():
            node = kind(context)
            warn_of_misspelled(node, node.unknown, parameters)
        run_in_order(node, stop)
    finally:
        context.try_shutdown()


def init_context(arguments: Sequence[str], stop: StopRequest) -> Context:
    """Initialise an rclpy context with the discovery defaults of this package and without rclpy's signal handlers.

    Raises:
        DrillTwinError: The arguments are not valid ROS arguments.
    """
    _refuse_misplaced(arguments)
    prepare()
    context = ArgumentsContext(arguments)
    try:
        with stop.at_once():
            rclpy.init(args=list(arguments), context=context, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy raises several classes of its own here, and RuntimeError
        text = _first_line(error)
        hint = "" if ".yaml" in text else "; write -p NAME:=VALUE, -r FROM:=TO or --params-file FILE.yaml"
        raise DrillTwinError(f"ROS arguments: {text}{hint}") from error
    if left := remove_ros_args(["", *arguments])[1:]:
        context.try_shutdown()
        raise DrillTwinError(f"expected only --help or --ros-args ..., found {' '.join(left)!r}")
    return context


def _refuse_misplaced(arguments: Sequence[str]) -> None:
    """Refuse NAME:=VALUE outside --ros-args: ROS takes it for a remapping, and the parameter would keep its default."""
    in_ros_args = False
    for word, before in zip(arguments, ["", *arguments], strict=False):
        in_ros_args = word == "--ros-args" or (in_ros_args and word != "--")
        if ":=" in word and not (in_ros_args and before.startswith("-") and before != "--ros-args"):
            remedy = "-p" if in_ros_args else "--ros-args -p"
            raise DrillTwinError(
                f"expected -p NAME:=VALUE or -r FROM:=TO after --ros-args, found {word!r}; write {remedy} {word}"
            )


def run_in_order(node: TwinNode, stop: StopRequest) -> None:
    """Start, run and stop a node; destroys it."""
    try:
        with stop.at_once():
            node.start()
        with stop.soon():
            node.run(stop)
    finally:
        node.close()


def print_help(name: str, purpose: str, table: Sequence[Parameter], arguments: Sequence[str]) -> bool:
    """Print the text that --help or --parameters (the parameter file) asks for; returns whether one was given."""
    if {"-h", "--help"} & set(arguments):
        given = "[-p NAME:=VALUE ...] [--params-file FILE] [-r FROM:=TO ...]"
        print(f"usage: {name} [--parameters | --policy | --ros-args {given}]\n\n{file_text(name, purpose, table)}")
    elif list(arguments) == ["--parameters"]:
        print(file_text(name, purpose, table), end="")
    else:
        return False
    return True


def _first_line(error: BaseException) -> str:
    text = str(error).strip()
    line = text.splitlines()[0] if text else type(error).__name__
    return re.sub(r", at [^,\s]+:\d+", "", line).removeprefix("failed to initialize rcl: ")
