# SPDX-License-Identifier: Apache-2.0
"""`ros2 launch drill_twin replay.launch.py bag:=PATH`: a bag again, with a fresh analysis of it when asked."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, RegisterEventHandler
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = "drill_twin"
IN_NAMESPACE = [("/clock", "clock"), ("/tf", "tf"), ("/tf_static", "tf_static")]
"""Global names of ROS that each twin has in its own namespace."""

ARGUMENTS = (
    DeclareLaunchArgument("bag", description="Bag to replay: a folder, or a .mcap or .db3 file."),
    DeclareLaunchArgument(
        "rate", default_value="1.0", description="Times as fast as recorded; 0.0: as fast as it goes."
    ),
    DeclareLaunchArgument(
        "map",
        default_value="",
        description="Topics of the bag with other names than ours: /camera/marks=/marks/state, separated by spaces.",
    ),
    DeclareLaunchArgument(
        "twin", default_value="", description="Namespace of the twin in the bag, where it holds several: /rig2."
    ),
    DeclareLaunchArgument(
        "loop", default_value="false", choices=["true", "false"], description="Begin again at the end."
    ),
    DeclareLaunchArgument(
        "analyze",
        default_value="true",
        choices=["true", "false"],
        description="Analyse afresh; the recorded findings are then left out.",
    ),
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
    """Replayer, and an analyzer beside it when wanted."""
    analyze = LaunchConfiguration("analyze")
    findings = "/whirl/state /whirl/motion /whirl/onset /twin/summary"
    left_out = PythonExpression([f"'{findings}' if '", analyze, "' == 'true' else ''"])
    replayer = _node(
        "replayer",
        {
            "bag": ParameterValue(LaunchConfiguration("bag"), value_type=str),
            "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
            "map": ParameterValue(LaunchConfiguration("map"), value_type=str),
            "loop": ParameterValue(LaunchConfiguration("loop"), value_type=bool),
            "leave_out": ParameterValue(left_out, value_type=str),
            "twin": ParameterValue(LaunchConfiguration("twin"), value_type=str),
            "keep_namespace": False,
        },
    )
    nodes = [_node("analyzer", {}, condition=IfCondition(LaunchConfiguration("analyze"))), replayer]
    return LaunchDescription(
        [
            *ARGUMENTS,
            *nodes,
            *(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=_end_with_error)) for node in nodes),
            RegisterEventHandler(
                OnProcessExit(target_action=replayer, on_exit=[EmitEvent(event=Shutdown(reason="the bag is over"))])
            ),
        ]
    )


def _end_with_error(event: ProcessExited, context: LaunchContext) -> None:
    """End the launch when a node dies; launch turns the error that is raised here into exit code 1."""
    if event.returncode and not context.is_shutdown:
        raise RuntimeError(f"{event.process_name} ended with exit code {event.returncode}, so the launch ends")


def _clock() -> dict[str, object]:
    return {"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}


def _node(executable: str, parameters: dict[str, object], **more: object) -> Node:
    defaults = PathJoinSubstitution([FindPackageShare(PACKAGE), "nodes", f"{executable}.yaml"])
    return Node(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration("namespace"),
        parameters=[defaults, {**parameters, **_clock()}, LaunchConfiguration("params_file")],
        remappings=IN_NAMESPACE,
        output="screen",
        sigterm_timeout="10",
        **more,
    )
