# SPDX-License-Identifier: Apache-2.0
"""Parameters of the simulator node."""

from __future__ import annotations

from drill_twin.ros.core.node import AUTOSTART
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE

PARAMETERS = (
    SCENE,
    OVERRIDES,
    Parameter(
        "pace",
        "realtime",
        "realtime: frames at their wall-clock times; fast: as fast as possible; lockstep: each frame waits for the "
        "command stamped for it, so that a run is repeatable",
        choices=("realtime", "fast", "lockstep"),
    ),
    Parameter("frame_rate", 0.0, "published frames per simulated second; 0: as the scene says", "Hz", 0.0, 1000.0),
    Parameter(
        "accuracy",
        "",
        'largest error before the onset: chooses elements and step (docs/accuracy.md); "": as the scene says',
        such_as="1 %",
    ),
    Parameter("duration", 0.0, "simulated time after which the node ends; 0: runs until stopped", "s", 0.0, 1e6),
    Parameter(
        "frame_prefix",
        "",
        "put before the names of the frames of messages and tf, for twins that share a tf tree",
        such_as="rig2/",
    ),
    AUTOSTART,
    Parameter("wait_for_command", True, "whether simulated time stands still until the first good command"),
    Parameter(
        "command_timeout", 1.0, "wall time without a command that counts as silence", "s", 0.05, 3600.0, live=True
    ),
    Parameter(
        "on_silence",
        "ramp_if_lost",
        "what follows silence: hold the last set-point; ramp to the safe one; or ramp_if_lost: ramp where the "
        "source sent at a rate on /rig/command, hold what was sent once",
        choices=("ramp_if_lost", "hold", "ramp"),
        live=True,
    ),
    Parameter("safe_weight_on_bit", 0.0, "weight on bit of the safe set-point", "N", -1e7, 1e7, live=True),
    Parameter("safe_speed", 0.0, "top-drive speed of the safe set-point", "rev/s", -100.0, 100.0, live=True),
    Parameter("safe_ramp_time", 5.0, "time of the ramp to the safe set-point, simulated", "s", 0.0, 3600.0, live=True),
    Parameter(
        "max_weight_on_bit",
        0.0,
        "larger commands are refused; 0: ten times the scene's largest",
        "N",
        0.0,
        1e8,
        live=True,
    ),
    Parameter(
        "max_speed",
        0.0,
        "faster commands are refused; 0: ten times the scene's fastest",
        "rev/s",
        0.0,
        100.0,
        live=True,
    ),
    Parameter("negative_commands", False, "whether tension and left-hand rotation may be commanded", live=True),
    Parameter("step_frames", 1, "frames that one call of ~/step takes while paused", "", 1, 100000, live=True),
    Parameter(
        "checkpoint",
        "",
        'file to keep the state in (.npz); where it exists when the node starts, the run goes on from it; "": none',
        live=True,
    ),
    Parameter(
        "checkpoint_period",
        5.0,
        "wall time between checkpoints; 0: none but those of ~/save_checkpoint",
        "s",
        0.0,
        86400.0,
        live=True,
    ),
    Parameter(
        "saved_checkpoint",
        "",
        "file (.npz) that ~/save_checkpoint writes, nothing else overwrites and ~/load_checkpoint reads; "
        '"": that of checkpoint with _saved behind its name',
        live=True,
    ),
    Parameter(
        "marker_rate", 25.0, "pictures for RViz and Foxglove, per second of wall time", "Hz", 0.0, 100.0, live=True
    ),
    Parameter(
        "exaggeration",
        0.0,
        "factor by which the picture widens lateral motion; 0: chosen by size",
        "",
        0.0,
        10000.0,
        live=True,
    ),
)
