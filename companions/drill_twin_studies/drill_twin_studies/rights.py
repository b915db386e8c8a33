# SPDX-License-Identifier: Apache-2.0
"""Rights of the advisor and of the estimator."""

from drill_twin.io.messages.topics import (
    ADVICE_MAP,
    ADVICE_STATE,
    ESTIMATE,
    ESTIMATE_STATE,
    MEASURED_RIG_STATE,
    OF_NEAREST_TWIN,
    RIG_COMMAND,
    RIG_STATE,
    TWIN_SCENE,
    TWIN_SUMMARY,
)
from drill_twin.ros.permissions import READINGS, Rights

ADVISOR = Rights((ADVICE_STATE, ADVICE_MAP), (TWIN_SCENE, RIG_STATE, TWIN_SUMMARY))
ESTIMATOR = Rights(
    (ESTIMATE_STATE, *(ESTIMATE + topic for topic in OF_NEAREST_TWIN)),
    (MEASURED_RIG_STATE, RIG_STATE, RIG_COMMAND, *READINGS),  # the launch file lets it follow the simulator
)
