# SPDX-License-Identifier: Apache-2.0
"""`ros2 launch drill_twin replay.launch.py bag:=PATH`: a bag again, with a fresh analysis of it when asked."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.launch_description_sources.python_launch_file_utilities import load_python_launch_file_as_module

from drill_twin.ros.entry_points import REPLAY

STARTER = load_python_launch_file_as_module(str(Path(__file__).with_name("starter.py")))
argument = STARTER.argument
FINDINGS = "/whirl/state /whirl/motion /whirl/onset /twin/summary"
"""Topics of a bag that a fresh analysis replaces."""
ANALYZER_STARTS = 120.0  # s, at most; as the rig driver waits
FLAGS = {"analyze": "Analyse afresh; the recorded findings are then left out."}
ARGUMENTS = (
    DeclareLaunchArgument("bag", description="Bag to replay: a folder, or a .mcap or .db3 file."),
    argument("rate", "1.0", "Times as fast as recorded; 0.0: as fast as it goes."),
    argument(
        "map", "", "Topics of the bag with other names than ours: /camera/marks=/marks/state, separated by spaces."
    ),
    argument("twin", "", "Namespace of the twin in the bag, where it holds several: /rig2."),
    argument("loop", "false", "Begin again at the end."),
)


def generate_launch_description() -> LaunchDescription:
    """Replayer, and an analyzer beside it when wanted, for which the replayer waits."""
    starter = STARTER.Starter(REPLAY, FLAGS, required="replayer analyzer")

    def start(context: LaunchContext) -> list[object]:
        left_out = FINDINGS if context.launch_configurations["analyze"] == "true" else ""
        replayer = {"leave_out": left_out, "keep_namespace": False, "wait_timeout": ANALYZER_STARTS}
        return starter.nodes(context, replayer={"parameters": replayer})

    return starter.description(ARGUMENTS, start)
