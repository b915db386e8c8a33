# SPDX-License-Identifier: Apache-2.0
"""One quantity of the set-points: who commands it, since when, and what is applied."""

import math
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace

from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.ros.simulator.command_limits import SIMULATED, CommandStamps
from drill_twin.scene.set_points.command import Command

_AT_A_RATE = 3  # commands in a row, from which their source is expected to send on
_FRAMES = 20  # without a command until its source is lost; after a pause or slow frames a source needs a moment
_WINDOW = 5.0  # s, in which the numbers of one publisher go back once at most: when it is started anew
BY_HAND, ANONYMOUS = "by hand", "anonymous"
"""Commander where single values are in force, and where the source of `/rig/command` does not say its name."""


class CommandQuantity:
    """Weight on bit, with the speed of the block, or speed of the top drive.

    DDS does not tell a Python subscriber who sent a message. A source is therefore the name in the message; several
    publishers of one name are noticed by the numbers that each gives its messages, which go back again and again.
    """

    def __init__(
        self, name: str, fields: tuple[str, ...], settings: SimpleNamespace, clock: Callable[[], float]
    ) -> None:
        """Make the quantity; a run begins with `begin`.

        Args:
            name: What is commanded, in words.
            fields: Names of its set-points.
            settings: Parameters of the simulator, which may change.
            clock: Monotonic time [s].
        """
        self.name, self.fields, self._settings, self._clock = name, fields, settings, clock
        self.source: str | None = None
        """Last source of `/rig/command` that had the quantity; None before the first."""
        self.base, self.last_stamp = "", -1
        self._before: tuple[str | None, int] = (None, -1)  # before time went back: source, and its last stamp
        self._last_time = -math.inf

    def begin(self, first: Command) -> None:
        """Begin a run: forget who commanded, and hold a set-point until the first command."""
        self.go_on(first)
        self.source = None
        self._last_time = -math.inf
        self._source_time = -math.inf  # when the source was heard
        self.by_hand = False
        """True while the set-point in force is a single value; single values come on change and not at a rate."""
        self._in_a_row = self._frames = 0  # commands on /rig/command, and frames since the last of them

    def go_on(self, command: Command) -> None:
        """Go on at another time with a set-point in force, which counts as just received."""
        if self.base == SIMULATED:
            self._before = self.source, self.last_stamp
        self.base = ""
        """Time base of the stamps of the source."""
        self.last_stamp = -1
        """Stamp [ns] of the last command of the source, followed or refused; lockstep waits for it."""
        self.good = self.applied = command.part(self.fields)
        """The last good set-point, and the one applied at present, which may be a point of a ramp."""
        self._followed: Command | None = None  # the last one, which comes again and again
        self._last_time = self._source_time = self._clock()
        self._ramped, self._ramp_left = False, 0.0
        self._number, self._turns = -1, deque[float](maxlen=2)

    # --- arrivals -------------------------------------------------------------------------------------------------

    def is_in(self, command: Command) -> bool:
        """True where a command has a set-point of this quantity."""
        return any(not math.isnan(getattr(command, name)) for name in self.fields)

    def belongs_to_another(self, source: str | None) -> bool:
        """True while a source has this quantity that is not the given one."""
        taken = self.source is not None and self.source != source
        return taken and self._clock() - self._source_time <= self._settings.command_timeout

    def kept_base(self, source: str) -> str:
        """Time base that a source has to keep to; empty where its next stamp sets it."""
        return self.base if source == self.source and not self.silent else ""

    def is_before_reset(self, source: str, stamp: int, stamps: CommandStamps) -> bool:
        """True where a command was under way when time went back: its source has not stamped an earlier time since.

        The stamp of the next frame may have been the last one of the run before.
        """
        before, last = self._before
        if before != source or not last <= stamp <= last + 2 * NANOSECONDS:  # a later one is of another clock
            return False
        self._before = source, stamp
        return (now := stamps.now()) < last and stamp > now + stamps.period

    def hear(self, source: str, stamp: int, base: str) -> None:
        """Note a command of a source that may send, before its set-points are judged."""
        self.last_stamp, self._before = stamp, (None, -1)
        if source == self.source:
            self.base, self._source_time = base, self._clock()

    def follow(self, command: Command, source: str | None, base: str = "", number: int = 0) -> None:
        """Follow a good command; `source` is None for a single value."""
        if command != self._followed or self.ramps:
            self.good = command.part(self.fields).completed(self.applied if self.ramps else self.good)
            self._followed = command
        follows = self._frames < _FRAMES or not self.silent
        self._in_a_row, self._frames = 0 if source is None else self._in_a_row * follows + 1, 0
        self.by_hand, self._last_time = source is None, self._clock()
        if source is None:
            return
        if source != self.source:
            self.source, self.base, self._number = source, base, -1
            self._turns.clear()
        self._source_time = self._last_time
        if number <= self._number:
            self._turns.append(self._last_time)
        self._number = number

    # --- state ----------------------------------------------------------------------------------------------------

    @property
    def age(self) -> float:
        """Wall time since the last good command [s]; infinite before the first."""
        return self._clock() - self._last_time

    @property
    def silent(self) -> bool:
        """True while commands have stopped coming."""
        return bool(self._settings.command_timeout < self.age < math.inf)

    @property
    def ramps(self) -> bool:
        """True from a silence on that is followed by the ramp to the safe set-point.

        A source that sent at a rate is lost where it is silent: it ended, was killed or hangs.
        """
        lost = self._in_a_row >= _AT_A_RATE and self._frames >= _FRAMES
        follows = self._settings.on_silence
        return self.silent and (follows == "ramp" or (follows == "ramp_if_lost" and lost))

    @property
    def several_send(self) -> bool:
        """True while several publishers send as the source."""
        return len(self._turns) == 2 and self._clock() - self._turns[0] < _WINDOW

    @property
    def commander(self) -> str:
        """Commander: a source of `/rig/command` that is not silent, `BY_HAND` for single values; empty: nobody."""
        if self.ramps:
            return ""
        if self.by_hand:
            return BY_HAND
        return (self.source or ANONYMOUS) if self.belongs_to_another(None) else ""

    def advance(self, seconds: float) -> None:
        """Apply over the next `seconds` of simulated time the last good set-point, or a point of a ramp.

        A ramp leads to the safe set-point, and from there to the commands that come next.
        """
        self._frames += 1
        if self.ramps != self._ramped:
            self._ramped, self._ramp_left = self.ramps, self._settings.safe_ramp_time
        safe = Command(self._settings.safe_weight_on_bit, self._settings.safe_speed)
        target = safe.part(self.fields) if self._ramped else self.good
        if self._ramp_left > seconds:
            target = self.applied.mixed(target, seconds / self._ramp_left)
        self._ramp_left = max(self._ramp_left - seconds, 0.0)
        self.applied = target
