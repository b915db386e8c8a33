# SPDX-License-Identifier: Apache-2.0
"""Reader of a rig's signals: connects, judges what it reads, and connects again by itself; one class a protocol."""

from __future__ import annotations

import asyncio
import math
import time
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence

from drill_twin.core.errors import shortened
from drill_twin.gateway.event_loop import EventLoopThread
from drill_twin.gateway.signals import RigSignal
from drill_twin.gateway.soundness import CheckedValue, Judged, SoundnessCheck

PATIENCE = 3.0
"""Longest wait for an answer [s]."""
_FIRST_WAIT, _LONGEST_WAIT = 0.5, 5.0  # s between two attempts to connect


class RefusedError(Exception):
    """The rig's server is not to be used; the message says why."""


class RigReader(ABC):
    """Reads signals in a thread of its own; `judged` may be called from another."""

    def __init__(self, signals: Sequence[RigSignal], period: float) -> None:
        """Begin to read.

        Args:
            signals: Signals to read.
            period: Time between two readings [s].
        """
        self._signals, self._period = signals, period
        self._checks = [SoundnessCheck(signal) for signal in signals]
        self._judged: Sequence[Judged] = [Judged() for _ in signals]
        self._read_time = -math.inf
        self.fault = "not connected yet"
        """Reason why there is no connection; empty while there is one."""
        self.connections = 0
        """Connections made so far."""
        self._thread = EventLoopThread("rig_reader")
        self._thread.post(self._run())

    @abstractmethod
    async def connect_and_read(self) -> None:
        """Connect, call `_connected`, then `_take` for each reading; returns or raises when the connection ends."""

    def fault_of(self, index: int) -> str:
        """Reason why a signal is not used whatever its value; empty if there is none."""
        del index
        return ""

    def judged(self) -> Mapping[RigSignal, Judged]:
        """Latest value of each signal, with the verdict on it."""
        if time.monotonic() - self._read_time > PATIENCE + self._period:
            return {signal: Judged(fault=f"no connection: {self.fault or 'no answer'}") for signal in self._signals}
        return dict(zip(self._signals, self._judged, strict=True))

    def close(self) -> None:
        """Disconnect, and end the thread."""
        self._thread.close()

    async def _run(self) -> None:
        wait = _FIRST_WAIT
        while True:
            before = self.connections
            try:
                await self.connect_and_read()
                self.fault = "its server ended the connection"
            except Exception as error:  # noqa: BLE001 - a server may answer anything; it is told, and tried again
                text = str(error) or type(error).__name__
                self.fault = shortened(text.partition("\n")[0], 200)
            wait = _FIRST_WAIT if self.connections > before else min(2.0 * wait, _LONGEST_WAIT)
            await asyncio.sleep(wait)

    def _connected(self) -> None:
        self.connections, self.fault = self.connections + 1, ""

    def _take(self, readings: Iterable[CheckedValue]) -> None:
        """Judge a reading of each signal."""
        now = time.time()
        self._judged = [
            Judged(fault=fault) if (fault := self.fault_of(index)) else self._checks[index].judge(one, now)
            for index, one in enumerate(readings)
        ]
        self._read_time = time.monotonic()
