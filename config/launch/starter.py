# SPDX-License-Identifier: Apache-2.0
"""Launch arguments, the nodes of a table as actions, and what follows the end of a node; both launch files load it."""

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown, matches_action
from launch.events.process import ProcessExited, ShutdownProcess
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from drill_twin.ros.core.stop_request import END_WITH_PARENT
from drill_twin.ros.entry_points import PACKAGE, REPLAYER, SIMULATOR, Row, waits

IN_NAMESPACE = [("/clock", "clock"), ("/tf", "tf"), ("/tf_static", "tf_static")]
"""Global names of ROS that each twin has in its own namespace."""
_NOT_TEXT = ("duration", "rate", "loop", "use_sim_time")  # arguments that are numbers, or true or false
_RUNS_OUT = (SIMULATOR, REPLAYER)  # nodes with whose end the run is over
_REFUSED = 2  # exit code of a node that cannot start with what it was given
_RESPAWN_DELAY = 2.0  # s; a node that falls at once must not take the processor from the simulator


def argument(name: str, default: str, description: str, choices: Iterable[str] = ()) -> DeclareLaunchArgument:
    """Launch argument; true and false are the choices where one of them is the default."""
    words = ("true", "false") if default in {"true", "false"} else tuple(choices)
    return DeclareLaunchArgument(name, default_value=default, description=description, choices=words or None)


class Starter:
    """Starts the nodes of a table as the arguments of a launch say."""

    def __init__(
        self, table: Mapping[str, Row], purposes: Mapping[str, str], required: str, elsewhere: Iterable[str] = ()
    ) -> None:
        """Take what differs between launch files.

        Args:
            table: The nodes by name.
            purposes: What each flag asks for.
            required: Default of the argument `required`.
            elsewhere: Nodes that are waited for although this launch does not start them.
        """
        self._table, self._elsewhere = table, elsewhere
        self._given: set[str] = set()
        self._failed: set[str] = set()
        self._shared = (
            *(argument(row.flag, str(row.runs).lower(), purposes[row.flag]) for row in table.values() if row.flag),
            argument("required", required, "Nodes whose failure ends the launch, separated by spaces."),
            argument("respawn", "false", "Start a node again that failed and is not required."),
            argument("namespace", "", "Namespace of all nodes and topics."),
            argument(
                "use_sim_time",
                "false",
                "Whether the clock of the nodes is /clock, in the namespace; the twin goes by stamps in any case.",
            ),
            argument(
                "params_file", "", "Parameter file (YAML) for all nodes; an argument that is given goes before it."
            ),
        )

    def description(
        self, arguments: Iterable[DeclareLaunchArgument], start: Callable[[LaunchContext], list[Any]]
    ) -> LaunchDescription:
        """Launch of these arguments, and of the actions that `start` returns once they have their values."""
        note = OpaqueFunction(function=lambda context: self._given.update(context.launch_configurations))
        return LaunchDescription([note, *arguments, *self._shared, OpaqueFunction(function=start)])

    def nodes(self, context: LaunchContext, **details: Mapping[str, Any]) -> list[Any]:
        """Actions of the nodes that are asked for.

        Args:
            context: Context of the launch.
            details: Options of `LifecycleNode`, by node; parameters among them are values by name.

        Raises:
            RuntimeError: A package is not installed, or `required` names none of the nodes.
        """
        given = context.launch_configurations
        required = given["required"].split()
        if unknown := set(required) - self._table.keys():
            raise RuntimeError(f"required: expected some of {', '.join(self._table)}, found {', '.join(unknown)}")
        asked = [name for name, row in self._table.items() if not row.flag or given[row.flag] == "true"]
        actions: list[Any] = []
        for name in asked:
            self._refuse_what_is_not_installed(name)
            options = dict(details.get(name, {}))
            computed = {**waits(name, {*asked, *self._elsewhere}), **options.pop("parameters", {})}
            node = LifecycleNode(
                package=PACKAGE,
                executable=name,
                name=name,
                namespace=given["namespace"],
                parameters=self._parameters(name, computed, given),
                remappings=[*IN_NAMESPACE, *options.pop("remappings", ())],
                respawn=given["respawn"] == "true" and name not in required,
                respawn_delay=_RESPAWN_DELAY,
                output="screen",
                sigterm_timeout="10",
                # No node stays behind where launch itself is killed.
                additional_env={END_WITH_PARENT: str(os.getpid())},
                **options,
            )
            on_exit = partial(self._on_exit, node, name, required=name in required)
            actions += [node, RegisterEventHandler(OnProcessExit(target_action=node, on_exit=on_exit))]
        return actions

    def _parameters(self, name: str, computed: Mapping[str, Any], given: Mapping[str, str]) -> list[Any]:
        """Parameters of a node; the later go before the earlier: defaults, computed ones, file, arguments."""
        row = self._table[name]
        defaults = PathJoinSubstitution([FindPackageShare(row.package), "nodes", f"{name}.yaml"])
        arguments = {
            word: _value(yaml.safe_load(given[word]) if word in _NOT_TEXT else given[word])
            for word in (*row.takes.split(), "use_sim_time")
            if word in self._given
        }
        values = {name: _value(value) for name, value in computed.items() if value != ()}  # launch takes no empty list
        parts = (defaults if row.has_parameters else "", values, given["params_file"], arguments)
        return [part for part in parts if part]

    def _refuse_what_is_not_installed(self, name: str) -> None:
        row = self._table[name]
        try:
            get_package_prefix(row.package)
        except PackageNotFoundError:
            needs = f"{row.flag}:=true needs the package {row.package}, which is not installed"
            raise RuntimeError(needs) from None

    def _on_exit(
        self, node: LifecycleNode, name: str, event: ProcessExited, context: LaunchContext, *, required: bool
    ) -> list[EmitEvent]:
        """End the launch, or let it go on; launch turns the error that is raised here into exit code 1."""
        if context.is_shutdown:
            return []
        failed, refused = event.returncode != 0, event.returncode == _REFUSED
        if failed and (required or (refused and name not in self._failed)):
            raise RuntimeError(f"{event.process_name} ended with exit code {event.returncode}, so the launch ends")
        if not failed and name in _RUNS_OUT:
            return [EmitEvent(event=Shutdown(reason=f"{name} ended"))]
        self._failed.add(name)
        # A node that ended as asked, or would be refused again, is not started again.
        over = refused or not failed
        return [EmitEvent(event=ShutdownProcess(process_matcher=matches_action(node)))] if over else []


def _value(value: object) -> object:
    """Value of a parameter; launch would read a bare text as YAML."""
    return ParameterValue(value, value_type=str) if isinstance(value, str) else value
