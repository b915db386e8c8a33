# SPDX-License-Identifier: Apache-2.0
"""Command arbiter: refuses commands outside the limits, keeps the last good set-point, decides between sources.

A `/rig/command` names its source in `header.frame_id`; an empty name is one source too. The first source keeps the rig
until it has been silent for the command timeout; the commands of another are refused, and so are the single values on
`/rig/wob_command` and `/rig/rps_command`, which people type. Both are counted and told.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from drill_twin.core.errors import shortened
from drill_twin.scene.blocks.rig import FASTEST_BLOCK
from drill_twin.scene.set_points.command import Command

_REFUSAL_TOLD = 10.0  # s; for so long a refusal is a warning
_LETTERS_OF_A_NAME = 200
_AT_A_RATE = 3  # commands in a row, from which their source is expected to send on
_FRAMES = 20  # without a command until its source is lost; after a pause or slow frames a source needs a moment
BY_HAND, ANONYMOUS = "by hand", "anonymous"
"""Commander where single values are in force, and where the source of `/rig/command` does not say its name."""


@dataclass(frozen=True)
class CommandLimits:
    """Ranges of accepted set-points; both ends included."""

    weight_on_bit: tuple[float, float]
    """Weight on bit [N]."""
    rotation: tuple[float, float]
    """Top-drive speed [rad/s]."""
    block: tuple[float, float] = (-FASTEST_BLOCK, FASTEST_BLOCK)
    """Speed of the block [m/s]."""
    block_not_followed: str = ""
    """Reason why a speed of the block is not followed; empty where it is."""

    def why_refused(self, command: Command) -> tuple[str, str] | None:
        """Kind and sentence of the refusal; None for a good command."""
        checks = (
            ("weight on bit", command.weight_on_bit, self.weight_on_bit, 1.0, "N"),
            ("top-drive speed", command.rotation, self.rotation, math.tau, "rev/s"),
            ("speed of the block", command.block, self.block, 1.0, "m/s"),
        )
        for name, value, (low, high), unit, symbol in checks:
            if not math.isfinite(value):
                return "not_finite", f"{name}: expected a finite number, found {value / unit:g} {symbol}"
            if not low <= value <= high:
                return "out_of_range", (
                    f"{name}: expected {low / unit:g} to {high / unit:g} {symbol}, found {value / unit:g} {symbol}"
                )
        return None


@dataclass(frozen=True)
class Silence:
    """Behaviour when commands stop coming."""

    timeout: float
    """Wall time without a command after which it counts as silence [s]."""
    ramp: bool = False
    """True: ramp to the safe set-point; False: hold the last one."""
    ramp_if_lost: bool = False
    """True: ramp also where a source of `/rig/command` that sent at a rate is lost."""
    safe: Command = field(default_factory=lambda: Command(0.0, 0.0))
    """The safe set-point."""
    ramp_time: float = 5.0
    """Time to get there [s], simulated."""


class CommandArbiter:
    """Judges commands and holds the set-point."""

    def __init__(
        self, limits: CommandLimits, silence: Silence, first: Command, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.set_limits(limits, silence)
        self._clock = clock
        self.begin(first)

    def begin(self, first: Command) -> None:
        """Begin a run: forget all that came before, and hold a set-point until the first command."""
        self._good = self._applied = first
        self._last_time: float | None = None
        self._in_a_row = self._frames = 0  # commands on /rig/command, and frames since the last of them
        self.source: str | None = None
        """Last source of `/rig/command` that had the rig; None before the first."""
        self._source_time = -math.inf  # when it was heard
        self.last_stamp = -1
        """Stamp [ns] of the last `/rig/command` of the commander, followed or refused; lockstep waits for it."""
        self.accepted = 0
        """Commands followed."""
        self.refused: Counter[str] = Counter()
        """Commands refused, by kind: not_finite, out_of_range, malformed, other_source; block: its speed alone."""
        self.last_refusal = ""
        """The last refusal, in words."""
        self.by_hand = False
        """True while the set-point in force is from single values, which come on change and not at a rate."""
        self._last_refusal_time = -math.inf

    def set_limits(self, limits: CommandLimits, silence: Silence) -> None:
        """Apply other limits from now on."""
        self._limits, self._silence = limits, silence

    @property
    def limits(self) -> CommandLimits:
        """Limits in force."""
        return self._limits

    def resume(self, command: Command) -> None:
        """Resume a run in which this command was in force; it counts as just received."""
        self._good = self._applied = command
        self._last_time = self._clock()

    # --- arrivals -------------------------------------------------------------------------------------------------

    def command(self, stamp: int, command: Command, source: str = "") -> bool:
        """Receive a `/rig/command` with its stamp [ns]; returns False where its source does not have the rig."""
        source = shortened(source, _LETTERS_OF_A_NAME)
        if self._belongs_to_another(source, f"a command of {source or ANONYMOUS}"):
            return False
        self.last_stamp = stamp
        if self._judge(self._with_followed_block(command), by_hand=False) or source == self.source:
            self.source, self._source_time = source, self._clock()
        return True

    def weight_on_bit(self, value: float) -> None:
        """Receive a `/rig/wob_command` [N]."""
        if not self._belongs_to_another(None, f"a single weight on bit of {value:g} N"):
            self._judge(replace(self._in_force, weight_on_bit=value), by_hand=True)

    def speed(self, value: float) -> None:
        """Receive a `/rig/rps_command` [rev/s]."""
        if not self._belongs_to_another(None, f"a single top-drive speed of {value:g} rev/s"):
            self._judge(replace(self._in_force, rotation=value * math.tau), by_hand=True)

    def _belongs_to_another(self, source: str | None, what: str) -> bool:
        """Refuse a command of another source than the commander; returns True where it is refused."""
        holder = self.source
        if holder is None or source == holder or self._clock() - self._source_time > self._silence.timeout:
            return False
        self._refuse(
            "other_source",
            f"expected commands of {holder or ANONYMOUS} alone, which has the rig until it is silent for "
            f"{self._silence.timeout:g} s, found {what}; stop one of the two",
        )
        return True

    def malformed(self, reason: str) -> None:
        """Count a message that holds no command."""
        self._refuse("malformed", reason)

    def _refuse(self, kind: str, reason: str) -> None:
        self.refused[kind] += 1
        self.last_refusal, self._last_refusal_time = reason, self._clock()

    def _with_followed_block(self, command: Command) -> Command:
        """The command without a speed of the block that the scene does not follow, which is refused by itself."""
        reason = self._limits.block_not_followed
        if not reason or command.block == 0.0 or not math.isfinite(command.block):
            return command
        self._refuse(
            "block",
            f"speed of the block: expected none, since {reason}, found {command.block:g} m/s; the other set-points "
            "are followed",
        )
        return replace(command, block=0.0)

    def _judge(self, command: Command, *, by_hand: bool) -> bool:
        """Follow a command within the limits; returns whether it is."""
        if why := self._limits.why_refused(command):
            self._refuse(*why)
            return False
        follows = self.heard and (self.age <= self._silence.timeout or self._frames < _FRAMES)
        self._in_a_row, self._frames = 0 if by_hand else self._in_a_row * follows + 1, 0
        self._good, self.by_hand = command, by_hand
        self._last_time = self._clock()
        self.accepted += 1
        return True

    # --- state of the commands ----------------------------------------------------------------------------------

    @property
    def heard(self) -> bool:
        """True once a good command has come."""
        return self._last_time is not None

    @property
    def good(self) -> Command:
        """The last good set-point."""
        return self._good

    @property
    def age(self) -> float:
        """Wall time since the last good command [s]; infinite before the first."""
        return math.inf if self._last_time is None else self._clock() - self._last_time

    @property
    def silent(self) -> bool:
        """True while commands have stopped coming."""
        return self.heard and self.age > self._silence.timeout

    @property
    def source_lost(self) -> bool:
        """True while a source of `/rig/command` that sent at a rate is silent: it ended, was killed or hangs."""
        return self.silent and self._in_a_row >= _AT_A_RATE and self._frames >= _FRAMES

    @property
    def ramps(self) -> bool:
        """True from a silence on that is followed by the ramp to the safe set-point."""
        return (self.silent and self._silence.ramp) or (self._silence.ramp_if_lost and self.source_lost)

    @property
    def _in_force(self) -> Command:
        """Set-points that a single value joins; a lost source has none among them."""
        return self._applied if self.ramps else self._good

    @property
    def refused_recently(self) -> bool:
        """True for ten seconds after a command was refused."""
        return self._clock() - self._last_refusal_time < _REFUSAL_TOLD

    @property
    def last_was_refused(self) -> bool:
        """True where a command was refused after the last good one."""
        return self._last_refusal_time > (-math.inf if self._last_time is None else self._last_time)

    @property
    def applied(self) -> Command:
        """The set-point applied at present: the last good one, or a point of the ramp to the safe one."""
        return self._applied

    def set_point(self, seconds: float) -> Command:
        """Set-point to apply over the next `seconds` of simulated time."""
        self._frames += 1
        if self.ramps:
            share = min(seconds / self._silence.ramp_time, 1.0) if self._silence.ramp_time > 0.0 else 1.0
            self._applied = self._applied.towards(self._silence.safe, self._good, share)
        else:
            self._applied = self._good
        return self._applied

    @property
    def commander(self) -> str:
        """Commander: a source of `/rig/command` that is not silent, `BY_HAND` for single values; empty: nobody."""
        if self.ramps:
            return ""
        if self.by_hand:
            return BY_HAND
        heard = self.source is not None and self._clock() - self._source_time <= self._silence.timeout
        return (self.source or ANONYMOUS) if heard else ""
