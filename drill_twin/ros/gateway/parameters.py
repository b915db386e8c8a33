# SPDX-License-Identifier: Apache-2.0
"""Parameters of the gateway."""

from drill_twin.ros.core.parameters import Parameter

PARAMETERS = (
    Parameter("signals", "dwis", "file with a line a signal: an installed one by name (config/gateway/), or a path"),
    Parameter("host", "127.0.0.1", "address of the OPC UA server; 0.0.0.0: all of this machine"),
    Parameter("port", 4840, "port of the OPC UA server", "", 1, 65535),
    Parameter("rate", 10.0, "values a second on the OPC UA server", "Hz", 0.1, 50.0),
    Parameter("stale_after", 1.0, "age at which a value of the twin is marked uncertain", "s", 0.1, 3600.0),
)
