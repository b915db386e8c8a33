# SPDX-License-Identifier: Apache-2.0
"""Server of a rig with open62541 (o6): one variable, until its input ends."""

import json
import sys

import o6

server = o6.Server(port=int(sys.argv[1]))
with server:
    server.addVariable("WOB", server.objectsNode, 7.5, nodeId="ns=1;s=WOB")
    print(json.dumps("serving"), flush=True)
    sys.stdin.read()
