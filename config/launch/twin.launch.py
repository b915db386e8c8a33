# SPDX-License-Identifier: Apache-2.0
"""`ros2 launch drill_twin twin.launch.py`: simulator, rig driver and analyzer; each node has a flag."""

import os
from collections.abc import Sequence

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "drill_twin"
COMPANIONS = {
    "advise": ("advisor", "drill_twin_studies"),
    "estimate": ("estimator", "drill_twin_studies"),
    "gateway": ("gateway", "drill_twin_rig"),
    "watch": ("watch", "drill_twin_dashboard"),
}
"""Executable and package of the flags of companion packages."""
IN_NAMESPACE = [("/clock", "clock"), ("/tf", "tf"), ("/tf_static", "tf_static")]
"""Global names of ROS that each twin has in its own namespace."""
END_WITH_LAUNCH = {"DRILL_TWIN_END_WITH_PARENT": str(os.getpid())}
"""Environment of the nodes: none stays behind where launch itself is killed or dies of a signal."""


def _flag(name: str, default: str, description: str) -> DeclareLaunchArgument:
    return DeclareLaunchArgument(name, default_value=default, choices=["true", "false"], description=description)


ARGUMENTS = (
    _flag("simulate", "true", "Simulator; without it, the other nodes go by one that runs elsewhere."),
    _flag("drive", "true", "Rig driver, which plays the set-points; without it, others command the simulator."),
    _flag("analyze", "true", "Analyzer, which finds the onset of whirl."),
    _flag("record", "false", "Recorder of a bag."),
    _flag("advise", "false", "Advisor, which compares the set-points with a map."),
    _flag("estimate", "false", "Estimator, which follows what is measured."),
    _flag("gateway", "false", "Gateway to rig software by OPC UA; its parameters are given in params_file."),
    _flag("watch", "false", "Page in the browser; its address is in the output."),
    _flag("rviz", "false", "RViz with the string in its hole."),
    DeclareLaunchArgument(
        "scene", default_value="pa6_bench", description="Scene: an installed one by name, or a scene file by path."
    ),
    DeclareLaunchArgument(
        "pace",
        default_value="realtime",
        choices=["realtime", "fast", "lockstep"],
        description="Real time, as fast as possible, or each frame waits for its command.",
    ),
    DeclareLaunchArgument("duration", default_value="0.0", description="Simulated seconds; 0.0 runs until stopped."),
    DeclareLaunchArgument(
        "wob", default_value="", description='Weight on bit with its unit, as "40 N"; scene\'s if empty.'
    ),
    DeclareLaunchArgument("rpm", default_value="", description='Speed with its unit, as "120 rpm"; scene\'s if empty.'),
    DeclareLaunchArgument(
        "accuracy", default_value="", description='Largest error before the onset, as "1 %"; chooses elements and step.'
    ),
    DeclareLaunchArgument(
        "table", default_value="", description="CSV, MAT, LAS or WITSML table of measured set-points to play."
    ),
    DeclareLaunchArgument("bag", default_value="", description="New folder of the bag; named by date if empty."),
    DeclareLaunchArgument(
        "overrides",
        default_value="",
        description='Changes to the scene for simulator and driver, as "hole.radius=80 mm; effects.bow=off".',
    ),
    DeclareLaunchArgument(
        "checkpoint", default_value="", description="File that keeps the state; a new start goes on from it."
    ),
    DeclareLaunchArgument(
        "frame_prefix", default_value="", description='Put before the names of all frames, as "rig2/"; none if empty.'
    ),
    DeclareLaunchArgument(
        "map", default_value="", description="map.json for the advisor; it makes a coarse map of the scene if empty."
    ),
    DeclareLaunchArgument(
        "free",
        default_value="load_factor=0.8..1.2",
        description='Free numbers of the estimator, as "wall_friction.coefficient=0.1..0.4; load_factor=0.8..1.2".',
    ),
    DeclareLaunchArgument(
        "measured",
        default_value="rig/state",
        description="Topic that the estimator follows: the simulator as a hidden truth, or measured/rig/state.",
    ),
    DeclareLaunchArgument("watch_port", default_value="8000", description="Port of the page; 0: a free one."),
    DeclareLaunchArgument("namespace", default_value="", description="Namespace of all nodes and topics."),
    DeclareLaunchArgument(
        "use_sim_time",
        default_value="false",
        choices=["true", "false"],
        description="Whether the clock of the nodes is /clock, in the namespace; the twin goes by stamps in any case.",
    ),
    DeclareLaunchArgument(
        "params_file",
        default_value=PathJoinSubstitution([FindPackageShare(PACKAGE), "launch", "no_parameters.yaml"]),
        description="Parameter file (YAML) for all nodes; what it gives goes before the other arguments.",
    ),
)


def generate_launch_description() -> LaunchDescription:
    """Nodes with their parameter files, and what is given on the command line over them."""
    scene, analyze, record = _text("scene"), LaunchConfiguration("analyze"), LaunchConfiguration("record")
    waited = PythonExpression(
        ["'simulator' + ' analyzer' * ('", analyze, "' == 'true') + ' recorder' * ('", record, "' == 'true')"]
    )
    duration = ParameterValue(LaunchConfiguration("duration"), value_type=float)
    overrides = _text("overrides")
    state = {
        "scene": scene,
        "overrides": overrides,
        "accuracy": _text("accuracy"),
        "pace": _text("pace"),
        "duration": duration,
        "checkpoint": _text("checkpoint"),
        "frame_prefix": _text("frame_prefix"),
    }
    simulator = _node("simulator", state, condition=_asked("simulate"))
    driver = {
        "scene": scene,
        "overrides": overrides,
        "wob": _text("wob"),
        "rpm": _text("rpm"),
        "table": _text("table"),
        "wait_for": ParameterValue(waited, value_type=str),
    }
    nodes = [
        _node("recorder", {"bag": _text("bag")}, condition=_asked("record")),
        _node("analyzer", {}, condition=_asked("analyze")),
        _node("advisor", {"map": _text("map")}, condition=_asked("advise")),
        _node(
            "estimator",
            {"scene": scene, "free": _text("free")},
            also=[("measured/rig/state", LaunchConfiguration("measured"))],
            condition=_asked("estimate"),
        ),
        _node("gateway", {}, condition=_asked("gateway")),
        simulator,
        _node("rig_driver", driver, condition=_asked("drive")),
        _node(
            "watch",
            {},
            condition=_asked("watch"),
            arguments=["--no-browser", "--port", LaunchConfiguration("watch_port")],
        ),
    ]
    rviz_file = PathJoinSubstitution([FindPackageShare(PACKAGE), "views", "twin.rviz"])
    return LaunchDescription(
        [
            *ARGUMENTS,
            OpaqueFunction(function=_refuse_what_is_not_installed),
            *nodes,
            Node(
                package="rviz2",
                executable="rviz2",
                name="rviz2",
                namespace=LaunchConfiguration("namespace"),
                parameters=[_clock()],
                remappings=IN_NAMESPACE,
                arguments=[
                    "--display-config",
                    rviz_file,
                    "--fixed-frame",
                    [LaunchConfiguration("frame_prefix"), "hole"],
                ],
                condition=_asked("rviz"),
            ),
            *(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=_end_with_error)) for node in nodes),
            RegisterEventHandler(
                OnProcessExit(target_action=simulator, on_exit=[EmitEvent(event=Shutdown(reason="simulator ended"))])
            ),
        ]
    )


def _end_with_error(event: ProcessExited, context: LaunchContext) -> None:
    """End the launch when a node dies; launch turns the error that is raised here into exit code 1."""
    if event.returncode and not context.is_shutdown:
        raise RuntimeError(f"{event.process_name} ended with exit code {event.returncode}, so the launch ends")


def _refuse_what_is_not_installed(context: LaunchContext) -> list[object]:
    """Refuse a flag whose package is not installed, before any node starts."""
    for flag, (_, package) in COMPANIONS.items():
        if context.launch_configurations[flag] == "true":
            try:
                get_package_prefix(package)
            except PackageNotFoundError:
                raise RuntimeError(f"{flag}:=true needs the package {package}, which is not installed") from None
    return []


def _asked(flag: str) -> IfCondition:
    return IfCondition(LaunchConfiguration(flag))


def _text(argument: str) -> ParameterValue:
    """A launch argument as a text parameter, whatever it looks like."""
    return ParameterValue(LaunchConfiguration(argument), value_type=str)


def _clock() -> dict[str, object]:
    return {"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}


def _node(executable: str, parameters: dict[str, object], also: Sequence[object] = (), **more: object) -> Node:
    package = dict(COMPANIONS.values()).get(executable, PACKAGE)
    defaults = PathJoinSubstitution([FindPackageShare(package), "nodes", f"{executable}.yaml"])
    given = LaunchConfiguration("params_file")
    return Node(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration("namespace"),
        # The page has no parameters of its own.
        parameters=[*([] if executable == "watch" else [defaults]), {**parameters, **_clock()}, given],
        remappings=[*IN_NAMESPACE, *also],
        output="screen",
        sigterm_timeout="10",
        additional_env=END_WITH_LAUNCH,
        **more,
    )
