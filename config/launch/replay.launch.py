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
        "loop", default_value="false", choices=["true", "false"], description="Begin again at the end."
    ),
    DeclareLaunchArgument(
        "analyze",
        default_value="true",
        choices=["true", "false"],
        description="Analyse afresh; the recorded findings are then left out.",
    ),
    DeclareLaunchArgument("namespace", default_value="", description="Namespace of all nodes and topics."),
)


def generate_launch_description() -> LaunchDescription:
    """Replayer, and an analyzer beside it when wanted."""
    analyze = LaunchConfiguration("analyze")
    left_out = PythonExpression(["'/whirl/state /whirl/motion /whirl/onset' if '", analyze, "' == 'true' else ''"])
    replayer = _node(
        "replayer",
        {
            "bag": ParameterValue(LaunchConfiguration("bag"), value_type=str),
            "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
            "map": ParameterValue(LaunchConfiguration("map"), value_type=str),
            "loop": ParameterValue(LaunchConfiguration("loop"), value_type=bool),
            "leave_out": ParameterValue(left_out, value_type=str),
        },
    )
    nodes = [_node("analyzer", {}, condition=IfCondition(analyze)), replayer]
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
    """End the launch, with exit code 1, when a node dies: an error here is what launch makes that code of."""
    if event.returncode and not context.is_shutdown:
        raise RuntimeError(f"{event.process_name} ended with exit code {event.returncode}, so the launch ends")


def _node(executable: str, parameters: dict[str, object], **more: object) -> Node:
    defaults = PathJoinSubstitution([FindPackageShare(PACKAGE), "nodes", f"{executable}.yaml"])
    return Node(
        package=PACKAGE,
        executable=executable,
        name=executable,
        namespace=LaunchConfiguration("namespace"),
        parameters=[defaults, parameters],
        output="screen",
        sigterm_timeout="10",
        **more,
    )
