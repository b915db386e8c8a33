# SPDX-License-Identifier: Apache-2.0
"""Parameters of the estimator."""

from __future__ import annotations

from types import SimpleNamespace

from drill_twin.api.estimator import Estimator
from drill_twin.ros.core.node import AUTOSTART
from drill_twin.ros.core.parameters import Parameter, ParameterError
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE, pairs_of, scene_of
from drill_twin.studies.estimation import EstimatorOptions

PARAMETERS = (
    SCENE,
    OVERRIDES,
    Parameter(
        "free", "load_factor=0.8..1.2", 'free numbers and their ranges as KEY=LO..HI, separated by ";"',
        such_as="wall_friction.coefficient=0.1..0.4; load_factor=0.8..1.2",
    ),
    Parameter(
        "channels", "torque hookload",
        "channels that correct: torque, or motor_torque with inertia and bearings of the drive; hookload, "
        "top_drive_speed, bit_speed",
    ),
    Parameter(
        "subs", "",
        "downhole subs of the scene whose readings correct, by name; of a real rig as measured/NAME",
        such_as="measured/near_bit",
    ),
    Parameter(
        "set_points", "command", "where set-points come from: /rig/command, the measured message, or the scene", "",
        choices=("command", "measured", "scene"),
    ),
    Parameter("members", 64, "members of the ensemble", "", 4, 1000),
    Parameter("window", 1.0, "time from estimate to estimate", "s", 0.05, 60.0),
    Parameter("rate", 10.0, "samples a second that are compared", "Hz", 0.1, 1000.0),
    Parameter("error", 0.02, "error of a sample, over the largest value of its channel", "", 1e-6, 1.0),
    Parameter("horizon", 4.0, "time ahead for which the chance of whirl is computed; 0: it is not", "s", 0.0, 60.0),
    Parameter("show", True, "publish the member nearest to the rig under estimate/"),
    Parameter("seed", 1, "seed of the draws", "", 0, 2**31 - 1),
    AUTOSTART,
)  # fmt: skip


def make_estimator(settings: SimpleNamespace) -> Estimator:
    """Estimator of the parameters.

    Raises:
        DrillTwinError: Scene, numbers or channels cannot be taken.
    """
    free = pairs_of("free", settings.free)
    if not free:
        raise ParameterError('parameter free: expected at least one KEY=LO..HI, found ""')
    names = ("members", "window", "rate", "error", "horizon", "seed")
    options = EstimatorOptions(frames=settings.show, **{name: getattr(settings, name) for name in names})
    return Estimator(
        scene_of(settings), free, channels=settings.channels.split(), subs=settings.subs.split(), options=options
    )
