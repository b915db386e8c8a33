# SPDX-License-Identifier: Apache-2.0
"""Parameters of the gateway."""

from drill_twin.ros.core.node import AUTOSTART
from drill_twin.ros.core.parameters import Parameter

PARAMETERS = (
    Parameter("signals", "dwis", "file with a line a signal: an installed one by name (config/gateway/), or a path"),
    Parameter("host", "127.0.0.1", "address of the OPC UA server; 0.0.0.0: all of this machine"),
    Parameter("port", 4840, "port of the OPC UA server", "", 1, 65535),
    Parameter("rate", 10.0, "values a second on the OPC UA server", "Hz", 0.1, 50.0),
    Parameter(
        "keys",
        "",
        "folder of keys (drill-twin gateway-keys): clients need a trusted certificate, encryption and a user; "
        '"": everybody reads without encryption, on this host only, and nobody commands',
    ),
    Parameter(
        "grant",
        "ask",
        "control that a client requests: ask: granted by ~/grant_control; always: granted at once; never: denied",
        choices=("ask", "always", "never"),
        live=True,
    ),
    Parameter("heartbeat_timeout", 2.0, "wall time without a heartbeat after which control is lost", "s", 0.2, 60.0),
    Parameter("safe_weight_on_bit", 0.0, "weight on bit once control is lost", "N", -1e7, 1e7, live=True),
    Parameter("safe_speed", 0.0, "top-drive speed once control is lost", "rev/s", -100.0, 100.0, live=True),
    Parameter("safe_ramp_time", 5.0, "time to the safe set-point, by the wall clock", "s", 0.0, 3600.0, live=True),
    Parameter(
        "rig_url",
        "",
        "server of a rig (OPC UA, or WITS level 0 as wits://rig:5001), whose signals of the sections measure and "
        'follow are read; "": none',
        such_as="opc.tcp://rig:4840",
    ),
    Parameter(
        "rig_security",
        "sign_and_encrypt",
        "connection with it: sign_and_encrypt: with keys, Basic256Sha256; none: open, and set-points are followed on "
        "this host only",
        choices=("sign_and_encrypt", "none"),
    ),
    Parameter("rig_user", "", 'user on it, whose password is in the file rig_password in keys; "": anonymous'),
    Parameter("rig_rate", 10.0, "readings of it a second", "Hz", 0.1, 50.0),
    Parameter("stale_after", 1.0, "age at which a value of the twin is marked uncertain", "s", 0.1, 3600.0),
    AUTOSTART,
)
