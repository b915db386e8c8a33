# SPDX-License-Identifier: Apache-2.0
"""`ros2 launch drill_twin twin.launch.py`: simulator, rig driver and analyzer; each node has a flag."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.launch_description_sources.python_launch_file_utilities import load_python_launch_file_as_module
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from drill_twin.ros.entry_points import PACKAGE, TWIN

STARTER = load_python_launch_file_as_module(str(Path(__file__).with_name("starter.py")))
argument = STARTER.argument
FLAGS = {
    "simulate": "Simulator; without it, the other nodes go by one that runs elsewhere.",
    "drive": "Rig driver, which plays the set-points; without it, others command the simulator.",
    "analyze": "Analyzer, which finds the onset of whirl.",
    "record": "Recorder of a bag.",
    "advise": "Advisor, which compares the set-points with a map.",
    "estimate": "Estimator, which follows what is measured.",
    "gateway": "Gateway to rig software by OPC UA; its parameters are given in params_file.",
    "watch": "Page in the browser; its address is in the output.",
}
ARGUMENTS = (
    argument("scene", "pa6_bench", "Scene: an installed one by name, or a scene file by path."),
    argument(
        "pace",
        "realtime",
        "Real time, as fast as possible, or each frame waits for its command.",
        ("realtime", "fast", "lockstep"),
    ),
    argument("duration", "0.0", "Simulated seconds; 0.0 runs until stopped."),
    argument("wob", "", 'Weight on bit with its unit, as "40 N"; scene\'s if empty.'),
    argument("rpm", "", 'Speed with its unit, as "120 rpm"; scene\'s if empty.'),
    argument("accuracy", "", 'Largest error before the onset, as "1 %"; chooses elements and step.'),
    argument("table", "", "CSV, MAT, LAS or WITSML table of measured set-points to play."),
    argument("bag", "", "New folder of the bag; named by date if empty."),
    argument(
        "overrides", "", 'Changes to the scene for simulator and driver, as "hole.radius=80 mm; effects.bow=off".'
    ),
    argument("checkpoint", "", "File that keeps the state; a new start goes on from it."),
    argument("frame_prefix", "", 'Put before the names of all frames, as "rig2/"; none if empty.'),
    argument("map", "", "map.json for the advisor; it makes a coarse map of the scene if empty."),
    argument(
        "free",
        "load_factor=0.8..1.2",
        'Free numbers of the estimator, as "wall_friction.coefficient=0.1..0.4; load_factor=0.8..1.2".',
    ),
    argument(
        "measured",
        "rig/state",
        "Topic that the estimator follows: the simulator as a hidden truth, or measured/rig/state.",
    ),
    argument("watch_port", "8000", "Port of the page; 0: a free one."),
    argument("rviz", "false", "RViz with the string in its hole."),
)


def generate_launch_description() -> LaunchDescription:
    """Nodes of a twin; without simulator and driver a launch has nothing to show, so both are required."""
    starter = STARTER.Starter(TWIN, FLAGS, required="simulator rig_driver", elsewhere=("simulator",))

    def start(context: LaunchContext) -> list[object]:
        given = context.launch_configurations
        nodes = starter.nodes(
            context,
            estimator={"remappings": [("measured/rig/state", given["measured"])]},
            watch={"arguments": ["--no-browser", "--port", given["watch_port"]]},
        )
        return [*nodes, *([_rviz(given)] if given["rviz"] == "true" else [])]

    return starter.description(ARGUMENTS, start)


def _rviz(given: dict[str, str]) -> Node:
    layout = PathJoinSubstitution([FindPackageShare(PACKAGE), "views", "twin.rviz"])
    return Node(
        package="rviz2",
        executable="rviz2",
        name="rviz2",
        namespace=given["namespace"],
        parameters=[{"use_sim_time": given["use_sim_time"] == "true"}],
        remappings=STARTER.IN_NAMESPACE,
        arguments=["--display-config", layout, "--fixed-frame", f"{given['frame_prefix']}hole"],
    )
