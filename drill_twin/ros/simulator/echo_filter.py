# SPDX-License-Identifier: Apache-2.0
"""Echo filter: tells a driver's echoes on the single-value topics from values of other sources.

DDS does not tell a Python subscriber who sent a message, so an echo is known by its value: it is bit for bit one of
the driver's commands. The two come on different topics, in either order. A value is matched as soon as its command
is there, so it does not matter how many commands a second there are; one whose command has not come after half a
second is no echo.
"""

from __future__ import annotations

import math
from collections import deque

from drill_twin.scene.set_points.command import Command

_REMEMBERED = 1000  # commands and open questions; a flood must not fill the memory
_GRACE = 0.5  # s for the command of an echo to arrive


class EchoFilter:
    """Tells echoes of `/rig/command` on the single-value topics from values of other sources."""

    def __init__(self) -> None:
        self._said: tuple[dict[float | None, None], ...] = ({}, {})  # weights and speeds, the oldest first
        self._open: deque[tuple[float, int, float | None]] = deque(maxlen=_REMEMBERED)
        self.strangers = 0
        """Number of values that were no echo."""
        self.last_stranger = -math.inf
        """Time of the last of them [s]."""

    def command(self, command: Command) -> None:
        """Receive a command of a driver."""
        pair = (_key(command.weight_on_bit), _key(command.rotation / math.tau))
        for said, value in zip(self._said, pair, strict=True):
            said.pop(value, None)
            said[value] = None
            if len(said) > _REMEMBERED:
                del said[next(iter(said))]
        if self._open:
            self._open = deque((doubt for doubt in self._open if pair[doubt[1]] != doubt[2]), maxlen=_REMEMBERED)

    def weight_on_bit(self, now: float, value: float) -> None:
        """Receive a `/rig/wob_command` [N] beside a driver at a time [s]."""
        self._single(now, 0, value)

    def speed(self, now: float, value: float) -> None:
        """A `/rig/rps_command` [rev/s] came beside a driver at this time [s]."""
        self._single(now, 1, value)

    def _single(self, now: float, which: int, value: float) -> None:
        if _key(value) not in self._said[which]:
            self._open.append((now, which, _key(value)))

    def settle(self, now: float) -> None:
        """Give up waiting for the commands of values that came too long ago; call about once a second."""
        while self._open and now - self._open[0][0] > _GRACE:
            self.last_stranger = self._open.popleft()[0]
            self.strangers += 1


def _key(value: float) -> float | None:
    """A NaN is not equal to itself, but it is its own echo."""
    return None if math.isnan(value) else value
