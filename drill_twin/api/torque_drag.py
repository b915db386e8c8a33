# SPDX-License-Identifier: Apache-2.0
"""Torque, drag and buckling of a scene in the operations of a rig, without a run."""

from collections.abc import Sequence
from pathlib import Path

from drill_twin.api.result_views import StaticLoads
from drill_twin.api.rotordynamics import final_command, steady_scene
from drill_twin.api.scenes import Overrides
from drill_twin.dynamics.torque_drag import analysis
from drill_twin.dynamics.torque_drag.over_depth import OverDepth, over_depth
from drill_twin.dynamics.torque_drag.soft_string import FEED, TRIP_SPEED, Operation, operations
from drill_twin.report.quantities import string_weight
from drill_twin.scene import Scene


def statics(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    trip_speed: float = TRIP_SPEED,
    feed: float = FEED,
    only: Sequence[Operation] = (),
) -> StaticLoads:
    """Hookload, torque, loads along the string and margins when tripping, rotating, sliding and drilling.

    >>> loads = statics("wells/s_shaped")["trip out"]
    >>> loads.hookload, loads.along.side_force.max(), loads.margins

    Args:
        scene: The scene, or its name or file; sliding and drilling take its final weight on bit and rotation. A weight
            given at the top is the weight on bit less the weight of the string.
        overrides: Values that replace the scene's values.
        without: Effects to leave out.
        trip_speed: Speed along the hole when tripping [m/s].
        feed: Rate of penetration when sliding and drilling [m/s].
        only: Operations in place of the five.

    Raises:
        SceneError: The scene cannot be loaded.
        RunError: No operation has a balance.
    """
    own = steady_scene(scene, overrides, without)
    command = final_command(own)
    # A load at the top is carried on to the bit together with the weight of the string.
    hanging = string_weight(own) if own.rig.weight_on_bit.at == "top" else 0.0
    wanted = tuple(only) or operations(command.weight_on_bit + hanging, command.rotation, trip_speed, feed)
    found = analysis.analyse(own, wanted)
    return StaticLoads(own, found.operations, found.notes)


def statics_over_depth(
    scene: Scene | str | Path,
    friction: Sequence[float],
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    depths: int = 40,
) -> OverDepth:
    """Hookload and torque of the soft string while its bit goes from the surface to the depth of the scene.

    Args:
        scene: The scene, or its name or file.
        friction: Coefficients on the wall; an interval with a coefficient of its own keeps it.
        overrides: Values that replace the scene's values.
        without: Effects to leave out.
        depths: Number of depths.

    Raises:
        SceneError: The scene cannot be loaded.
    """
    return over_depth(steady_scene(scene, overrides, without), friction, depths)
