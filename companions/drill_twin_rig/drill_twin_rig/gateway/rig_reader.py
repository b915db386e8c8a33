# SPDX-License-Identifier: Apache-2.0
"""Reader of a rig's signals, in a thread of its own: connects, judges what it reads, and connects again by itself.

There is one class a protocol. Value, stamp and unit of a signal are checked at each reading.
"""

import asyncio
import math
import threading
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Coroutine, Iterable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from typing import Any, NamedTuple, TypeVar

from drill_twin.core.errors import shortened
from drill_twin.core.missing import CERTAIN, LiveChannel, beyond
from drill_twin.core.units.quantity import show
from drill_twin.core.units.registry import UnitError, si_factor
from drill_twin_rig.gateway.signals import RigSignal

_AHEAD = 2.0
"""Time by which a stamp may be later than the clock of this machine [s]; not measured."""


class SignalReading(NamedTuple):
    """Reading of a node."""

    value: object
    """Value as the server gave it."""
    status: str
    """Name of a status that is not good; empty for a good one."""
    stamp: float
    """Source timestamp [s since 1970]; NaN without one."""


class CheckedValue(NamedTuple):
    """Value with the verdict on it."""

    value: float = math.nan
    """Value [SI]; NaN for a value that is not sound."""
    stamp: float = math.nan
    """Source timestamp, or time of the reading where the server gives none [s since 1970]."""
    fault: str = "no value yet"
    """Reason why the value is not used; empty for a sound one."""


class QualityCheck:
    """Judges one signal."""

    def __init__(self, signal: RigSignal) -> None:
        self._signal, self._channel, self._seen = signal, LiveChannel(), ""
        self.left_out = Counter[str]()
        """Numbers of readings that were not used, by the kind of their fault."""
        self._last: float | None = None
        self._changed = 0.0

    def check(self, reading: SignalReading, now: float) -> CheckedValue:
        """Judge a reading at a time [s since 1970]."""
        again, self._seen = str(reading) == self._seen, str(reading)
        fault = self._fault(reading, now, again=again)
        self.left_out[fault.partition(", found")[0]] += bool(fault) and not again
        if fault or not isinstance(reading.value, int | float):
            return CheckedValue(fault=fault)
        stamp = reading.stamp if math.isfinite(reading.stamp) else now
        return CheckedValue(float(reading.value) * self._signal.factor, stamp, "")

    def _fault(self, reading: SignalReading, now: float, *, again: bool) -> str:
        signal, value = self._signal, reading.value
        if reading.status:
            return f"status {reading.status}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            return f"expected a number, found {show(value)}"
        if not math.isfinite(value):
            return f"expected a finite number, found {value}"
        is_beyond, what = beyond(signal.quantity, value * signal.factor)
        is_null = self._channel.is_missing(value, keep=not (again or is_beyond))
        if value == CERTAIN or (is_null and not signal.is_typed):
            return f"{value:g} stands for no value"
        if is_beyond:
            return f"{what}, found {value:g} {signal.unit}"
        if not signal.low <= value <= signal.high:
            return f"expected {signal.low:g} to {signal.high:g} {signal.unit}, found {value:g} {signal.unit}"
        if signal.stale_after and not math.isfinite(reading.stamp):
            return "no source timestamp"
        if signal.stale_after and now - reading.stamp > signal.stale_after:
            return "stale stamp"
        if reading.stamp - now > _AHEAD:
            return "stamp in the future"
        if value != self._last:
            self._last, self._changed = float(value), now
        frozen = 0.0 < signal.frozen_after <= now - self._changed
        return f"frozen for more than {signal.frozen_after:g} s" if frozen else ""


def unit_fault(signal: RigSignal, found: str) -> str:
    """Reason why the unit that a server gives to a signal is not its line's unit; empty if both are the same.

    Args:
        signal: The signal.
        found: Text of the unit on the server; empty where it gives none.
    """
    with suppress(UnitError):
        if not found or si_factor(found) == si_factor(signal.unit):
            return ""
    return f"wrong unit: expected {signal.unit}, found {found} on the server"


_T = TypeVar("_T")


class EventLoopThread:
    """Runs coroutines while the calling thread does other work."""

    def __init__(self, name: str) -> None:
        self._loop, self._over = asyncio.new_event_loop(), asyncio.Event()
        self._posted: Future[object] | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._over.wait())

    def call(self, coroutine: Coroutine[Any, Any, _T], seconds: float = 30.0) -> _T:
        """Run a coroutine and wait for its result, at most this long [s]; raises what it raises, or TimeoutError."""
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(seconds)

    def post(self, coroutine: Coroutine[Any, Any, object]) -> None:
        """Run a coroutine without waiting for it; its error is raised by the next call of this method."""
        if self._posted is not None and self._posted.done():
            self._posted.result()
        self._posted = asyncio.run_coroutine_threadsafe(coroutine, self._loop)

    def close(self) -> None:
        """Cancel what still runs, and end the thread."""
        self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join()


PATIENCE = 3.0
"""Longest wait for an answer [s]."""
_WAIT = 1.0
"""Time between two attempts to connect [s]; not measured."""


class RefusedError(Exception):
    """The rig's server is not to be used; the message says why."""


class RigReader(ABC):
    """Reads signals in a thread of its own; `checked` may be called from another."""

    def __init__(self, signals: Sequence[RigSignal], period: float) -> None:
        """Begin to read.

        Args:
            signals: Signals to read.
            period: Time between two readings [s].
        """
        self._signals, self._period = signals, period
        self._checks = [QualityCheck(signal) for signal in signals]
        self._checked: Sequence[CheckedValue] = [CheckedValue() for _ in signals]
        self._read_time = -math.inf
        self._unusable = [""] * len(signals)  # reason why a signal is not used whatever its value; empty: it is
        self.fault = "not connected yet"
        """Reason why there is no connection; empty while there is one."""
        self.connections = 0
        """Connections made so far."""
        self._thread = EventLoopThread("rig_reader")
        self._thread.post(self._run())

    @abstractmethod
    async def connect_and_read(self) -> None:
        """Connect, call `_connected`, then `_take` for each reading; returns or raises when the connection ends."""

    def checked(self) -> Mapping[RigSignal, CheckedValue]:
        """Latest value of each signal, with the verdict on it."""
        if time.monotonic() - self._read_time > PATIENCE + self._period:
            return {
                signal: CheckedValue(fault=f"no connection: {self.fault or 'no answer'}") for signal in self._signals
            }
        return dict(zip(self._signals, self._checked, strict=True))

    def left_out(self) -> dict[str, str]:
        """Readings of each quantity that were not used, counted by the kind of their fault."""
        counts = ((one.quantity, dict(check.left_out)) for one, check in zip(self._signals, self._checks, strict=True))
        return {name: ", ".join(f"{n} x {kind}" for kind, n in found.items() if n) for name, found in counts}

    def close(self) -> None:
        """Disconnect, and end the thread."""
        self._thread.close()

    async def _run(self) -> None:
        while True:
            try:
                await self.connect_and_read()
                self.fault = "the server of the rig ended the connection"
            except Exception as error:  # noqa: BLE001 - a server may answer anything; its error is told, and it is asked again
                self.fault = shortened((str(error) or type(error).__name__).partition("\n")[0], 200)
            await asyncio.sleep(_WAIT)

    def _connected(self) -> None:
        self.connections, self.fault = self.connections + 1, ""

    def _take(self, readings: Iterable[SignalReading]) -> None:
        """Judge a reading of each signal."""
        now = time.time()
        self._checked = [
            CheckedValue(fault=fault) if fault else check.check(one, now)
            for fault, check, one in zip(self._unusable, self._checks, readings, strict=True)
        ]
        self._read_time = time.monotonic()
