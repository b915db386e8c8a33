# SPDX-License-Identifier: Apache-2.0
"""Rights of the gateway."""

from drill_twin.io.messages.topics import (
    MARKS_STATE,
    MEASURED_RIG_STATE,
    REALTIME_FACTOR,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    TWIN_SCENE,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.ros.permissions import MEASURED_SUBS, Rights

GATEWAY = Rights(
    (RIG_COMMAND, MEASURED_RIG_STATE, *MEASURED_SUBS),
    (TWIN_SCENE, RIG_STATE, STRING_POSES, MARKS_STATE, WHIRL_STATE, WHIRL_ONSET, REALTIME_FACTOR),
    ("~/grant_control", "~/withdraw_control"),
)
