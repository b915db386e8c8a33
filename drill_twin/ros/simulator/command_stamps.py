# SPDX-License-Identifier: Apache-2.0
"""Stamps of commands: of simulated time or of the wall clock, as a publisher began, or zero for the time of arrival."""

import time
from collections.abc import Callable

from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.ros.simulator.command_limits import CommandError

SIMULATED, WALL = "simulated time", "the wall clock"
"""Time bases."""
_NEAR = NANOSECONDS // 2  # between a stamp and its time base
_IN_LOCKSTEP = NANOSECONDS  # a command may be for several frames


class CommandStamps:
    """Time bases of a simulator.

    In real time a stamp is within half a second of simulated time or of the wall clock, or zero. At the other paces the
    wall clock says nothing. As fast as possible a stamp may be of any time before, since time runs on while a command
    comes. In lockstep a command is for a frame, so zero is refused.
    """

    def __init__(self, pace: str, period: int, now: Callable[[], int]) -> None:
        """Take the pace.

        Args:
            pace: realtime, fast or lockstep.
            period: Simulated time of a frame [ns].
            now: Simulated time [ns].
        """
        self._pace, self.period, self.now = pace, period, now
        self._ahead = period + (_IN_LOCKSTEP if pace == "lockstep" else _NEAR)

    def base(self, stamp: int, kept: str) -> str:
        """Time base of a stamp [ns]; empty for zero.

        Args:
            stamp: The stamp.
            kept: Time base of the stamps that the publisher sent before; empty before the first.

        Raises:
            CommandError: The stamp is of no time base, or of another than the stamps before.
        """
        if not stamp and self._pace != "lockstep":
            return ""
        now = self.now()
        behind = now if self._pace == "fast" else _NEAR
        if stamp and now - behind <= stamp <= now + self._ahead:
            base = SIMULATED
        elif self._pace == "realtime" and abs(stamp - time.time_ns()) <= _NEAR:
            base = WALL
        else:
            raise self._refusal(stamp, now)
        if kept not in {"", base}:
            raise CommandError(
                "stamp_other_clock",
                f"stamp: expected {kept}, as this source began with, found {base}; keep to one, or stamp zero",
            )
        return base

    def _refusal(self, stamp: int, now: int) -> CommandError:
        wall = time.time_ns()
        by_wall = abs(stamp - wall) < abs(stamp - now)
        off = stamp - (wall if by_wall else now)
        kind = "ahead" if off > 0 else "behind"
        amount = f"{abs(round(seconds(off), 1)):.10g} s {kind}"
        remedy = "stamp by /clock"
        if not stamp:
            kind, found = "missing", "none"
        elif not by_wall:
            found = f"{seconds(stamp):.10g} s, {amount}"
        elif self._pace == "realtime":
            found, remedy = f"another clock, {amount}", "synchronise the clocks, or stamp zero"
        else:
            kind, found = "wall_clock", "a wall clock"
        expected = {
            "realtime": f"simulated time ({seconds(now):g} s), the wall clock, or zero",
            "fast": f"simulated time ({seconds(now):g} s) or zero",
            "lockstep": f"simulated time of a frame to come, from {seconds(now + self.period):g} s on",
        }[self._pace]
        return CommandError(f"stamp_{kind}", f"stamp: expected {expected}, found {found}; {remedy}")
