# SPDX-License-Identifier: Apache-2.0
"""Ports of this host for servers of tests."""

import itertools
import os
import socket

FIRST, COUNT = 20_000, 12_000
"""Below the range from which the kernel gives ports to clients: no connection of another test takes one meanwhile."""
_NUMBERS = itertools.count(97 * os.getpid())  # each worker in another place


def free_port():
    """A port of the loopback that is free now."""
    for number in itertools.islice(_NUMBERS, COUNT):
        with socket.socket() as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                one.bind(("127.0.0.1", FIRST + number % COUNT))
            except OSError:
                continue
            return one.getsockname()[1]
    raise OSError("no free port")
