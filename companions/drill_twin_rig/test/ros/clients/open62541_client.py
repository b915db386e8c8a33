# SPDX-License-Identifier: Apache-2.0
"""Client of the gateway with open62541 (o6): prints some of its signals as JSON."""

import json
import sys

import o6

with o6.Client(sys.argv[1]) as client:
    space = list(client.read("i=2255")).index("urn:drill_twin:gateway")
    print(json.dumps({name: float(client.read(f"ns={space};s={name}")) for name in ("WOB", "SurfaceRPM")}))
