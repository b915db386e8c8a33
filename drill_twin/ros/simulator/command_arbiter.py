# SPDX-License-Identifier: Apache-2.0
"""Command arbiter: from the bytes of a command to the set-point, or to a refusal that is counted and told.

A `/rig/command` names its source in `header.frame_id`; an empty name is one source too. It sets weight on bit,
top-drive speed or both. The first source of each keeps it until it has been silent for the command timeout; the
commands of another are refused, and so are the single values on `/rig/wob_command` and `/rig/rps_command`, which people
type.
"""

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from drill_twin.core.errors import MessageError, ParameterError, shortened
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.stamps import seconds
from drill_twin.ros.simulator.command_limits import CommandError, CommandLimits, CommandStamps, limits_for
from drill_twin.ros.simulator.command_quantity import ANONYMOUS, CommandQuantity
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import QUANTITIES, Command

_REFUSAL_TOLD = 10.0  # s; for so long a refusal is a warning
_LETTERS_OF_A_NAME = 200
_UNDER_WAY = 1.0  # s after time went back, in which commands of before still come and are no fault


class CommandArbiter:
    """Judges commands and holds the set-point. What takes a command returns the kind of its refusal, empty for none."""

    def __init__(
        self,
        scene: Scene,
        settings: SimpleNamespace,
        stamps: CommandStamps,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin a run.

        Args:
            scene: The scene; it limits the commands, and has the set-points before the first command.
            settings: Parameters of the simulator, of which live ones may change.
            stamps: Time bases.
            clock: Monotonic time [s].
        """
        self._scene, self._settings, self._stamps, self._clock = scene, settings, stamps, clock
        self._read = JointStateReader().read
        self.quantities = [CommandQuantity(name, fields, settings, clock) for name, fields in QUANTITIES.items()]
        self.set_limits()
        self.begin()

    def begin(self) -> None:
        """Begin a run: forget all that came before."""
        for quantity in self.quantities:
            quantity.begin(Command(*self._scene.rig.first))
        self._start_counts()

    def go_on(self, command: Command) -> None:
        """Go on at another time with this command in force."""
        for quantity in self.quantities:
            quantity.go_on(command)
        self._start_counts()

    def _start_counts(self) -> None:
        self.accepted = 0
        """Commands followed."""
        self.refused: Counter[str] = Counter()
        """Commands refused, by kind."""
        self.last_refusal = ""
        """The last refusal, in words."""
        self._last_refusal_time, self._begun = -math.inf, self._clock()

    def set_limits(self) -> None:
        """Apply the limits of the settings."""
        self.limits = self.limits_of(self._settings)
        """Limits in force."""

    def limits_of(self, settings: SimpleNamespace) -> CommandLimits:
        """Limits of settings.

        Raises:
            ParameterError: The safe set-point is outside them.
        """
        limits = limits_for(self._scene, settings)
        try:
            limits.check(Command(settings.safe_weight_on_bit, settings.safe_speed))
        except CommandError as error:
            raise ParameterError(f"parameters safe_weight_on_bit, safe_speed: {error}") from error
        return limits

    # --- arrivals -------------------------------------------------------------------------------------------------

    def message(self, raw: bytes, info: Mapping[str, Any]) -> str:
        """Receive the bytes of a `/rig/command`."""
        try:
            state = self._read(raw)
            command = read_command(state)
        except MessageError as error:
            return self.malformed(str(error))
        return self.command(state.stamp, command, state.frame_id, info["publication_sequence_number"])

    def weight_on_bit(self, value: float) -> str:
        """Receive a `/rig/wob_command` [N]."""
        return self.command(0, Command(value, math.nan, math.nan), None)

    def speed(self, value: float) -> str:
        """Receive a `/rig/rps_command` [rev/s]."""
        return self.command(0, Command(math.nan, value * math.tau, math.nan), None)

    def malformed(self, reason: str) -> str:
        """Count a message that holds no command."""
        return self._refuse("malformed", reason)

    def command(self, stamp: int, command: Command, source: str | None = "", number: int = 0) -> str:
        """Follow what is good and free of a command.

        Args:
            stamp: Its stamp [ns].
            command: Set-points, NaN where there is none.
            source: Name of who commands; None for a single value.
            number: Number that the publisher gave the message.
        """
        what = "a single value"
        if source is not None:
            source = shortened(source, _LETTERS_OF_A_NAME)
            what = f"a command of {source or ANONYMOUS}"
        command, left_out = self.limits.without_block(command)
        given = [quantity for quantity in self.quantities if quantity.is_in(command)]
        mine = [quantity for quantity in given if not quantity.belongs_to_another(source)]
        refusal = ""
        if not given and not left_out:
            refusal = self._refuse("not_finite", f"expected a set-point, found {what} without one")
        elif len(mine) < len(given):
            refusal = self._refuse("other_source", self._belongs_to_another(given, mine, what))
        try:
            bases = ["" if source is None else self._base(quantity, source, stamp) for quantity in mine]
            if len(mine) < len(given):
                command = command.part([name for quantity in mine for name in quantity.fields])
            if left_out and len(mine) == len(given):
                refusal = self._refuse("block", left_out)
            self.limits.check(command)
        except CommandError as error:
            return self._refuse(error.kind, str(error))
        for quantity, base in zip(mine, bases, strict=True):
            quantity.follow(command, source, base, number)
        self.accepted += bool(mine)
        return refusal

    def _belongs_to_another(self, given: list[CommandQuantity], mine: list[CommandQuantity], what: str) -> str:
        others = [quantity for quantity in given if quantity not in mine]
        holder, timeout = others[0].source, self._settings.command_timeout
        held = [quantity.name for quantity in self.quantities if quantity.source == holder]
        has = "rig" if len(held) == len(self.quantities) else held[0]
        free = f", whose {mine[0].name} is free" if mine else ""
        return (
            f"expected commands of {holder or ANONYMOUS} alone, which has the {has} until it is silent for "
            f"{timeout:g} s, found {what}{free}; stop one of the two"
        )

    def _base(self, quantity: CommandQuantity, source: str, stamp: int) -> str:
        """Time base of a stamp, which the quantity notes.

        Raises:
            CommandError: The stamp cannot be used.
        """
        if quantity.is_before_reset(source, stamp, self._stamps):
            raise CommandError(
                "before_reset",
                f"stamp: expected simulated time, which went back to {seconds(self._stamps.now()):g} s, found "
                f"{seconds(stamp):g} s, of the run before; stamp by /clock",
            )
        kept = quantity.kept_base(source)
        base = self._stamps.base(stamp, kept) or kept
        quantity.hear(source, stamp, base)
        return base

    def _refuse(self, kind: str, reason: str) -> str:
        self.refused[kind] += 1
        if kind != "before_reset" or self._clock() - self._begun > _UNDER_WAY:
            self.last_refusal, self._last_refusal_time = reason, self._clock()
        return kind

    # --- state of the commands ------------------------------------------------------------------------------------

    @property
    def heard(self) -> bool:
        """True once a good command has come."""
        return self.age < math.inf

    @property
    def age(self) -> float:
        """Wall time since the last good command [s]; infinite before the first."""
        return min(quantity.age for quantity in self.quantities)

    @property
    def kept(self) -> Command:
        """Set-points for a checkpoint: the last good ones, but of a ramp to the safe set-point where the ramp is."""
        weight, speed = (one.applied if one.ramps else one.good for one in self.quantities)
        return weight.completed(speed)

    @property
    def applied(self) -> Command:
        """The set-points applied at present: the last good ones, or points of ramps."""
        weight, speed = self.quantities
        return weight.applied.completed(speed.applied)

    @property
    def refused_recently(self) -> bool:
        """True for ten seconds after a command was refused."""
        return self._clock() - self._last_refusal_time < _REFUSAL_TOLD

    @property
    def last_was_refused(self) -> bool:
        """True where a command was refused after the last good one."""
        return self.heard and self._clock() - self._last_refusal_time < self.age

    @property
    def awaited(self) -> list[CommandQuantity]:
        """Quantities without a stamped command for the next frame, which a lockstep waits for.

        It waits for the source of each quantity that has one, and while there is none for the first.
        """
        stamped = [quantity for quantity in self.quantities if quantity.source is not None and not quantity.by_hand]
        return [quantity for quantity in stamped or self.quantities if quantity.last_stamp <= self._stamps.now()]

    @property
    def commander(self) -> str:
        """Commander, or the commander of each quantity in a list; empty: nobody."""
        found = {quantity.name: quantity.commander for quantity in self.quantities if quantity.commander}
        if len(set(found.values())) < 2:
            return next(iter(found.values()), "")
        return ", ".join(f"{commander} ({name})" for name, commander in found.items())

    def set_point(self, period: float) -> Command:
        """Set-points to apply over the next `period` [s] of simulated time."""
        for quantity in self.quantities:
            quantity.advance(period)
        return self.applied
