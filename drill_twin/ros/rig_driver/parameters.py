# SPDX-License-Identifier: Apache-2.0
"""Parameters of the rig driver."""

from drill_twin.ros.core.node import AUTOSTART
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE

PARAMETERS = (
    SCENE,
    Parameter(
        "weight_on_bit",
        "",
        "weight on bit in place of the scene's, with its unit; \"\": the scene's",
        live=True,
        such_as="40 N",
    ),
    Parameter(
        "rotation",
        "",
        "top-drive speed in place of the scene's, with its unit; \"\": the scene's",
        live=True,
        such_as="120 rpm",
    ),
    Parameter(
        "change_time", 1.0, "simulated time that a live change of a set-point takes", "s", 0.0, 3600.0, live=True
    ),
    Parameter(
        "table",
        "",
        "CSV, MAT, LAS or WITSML file of measured set-points to play in place of the schedule; its columns and units "
        'are those of rig.table in the scene (or overrides), or are found by their names; "": the scene\'s schedule',
    ),
    OVERRIDES,
    Parameter(
        "follow",
        "clock",
        "clock: send with the simulator's /clock; wall: send by the wall clock, for a simulator without one",
        choices=("clock", "wall"),
    ),
    Parameter("frame_rate", 0.0, "set-points per second; 0: the scene's frame rate", "Hz", 0.0, 1000.0),
    Parameter("wait_for", "simulator", "nodes that must be ready before the first set-point, separated by spaces"),
    Parameter("wait_timeout", 120.0, "longest wait for them", "s", 0.0, 3600.0),
    Parameter(
        "at_end",
        "hold",
        "hold: go on sending the last set-point when the schedule is over; stop: end the node",
        choices=("hold", "stop"),
        live=True,
    ),
    AUTOSTART,
)
