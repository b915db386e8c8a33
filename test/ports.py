# SPDX-License-Identifier: Apache-2.0
"""Ports of this host for servers of tests."""

import socket


def free_port():
    """A port of the loopback that is free now."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]
