# SPDX-License-Identifier: Apache-2.0
"""Limits of commands: ranges of the set-points, from the scene and the parameters, and the time bases of stamps."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import FASTEST_BLOCK, SetPoint
from drill_twin.scene.set_points.command import Command

_GENEROUS = 10.0  # times what the scene itself commands
_LEAST_WEIGHT = 100.0  # N
_LEAST_SPEED = 20.0 * math.pi  # rad/s, 10 rev/s
FASTEST = 200.0 * math.pi  # rad/s, 100 rev/s, as in a scene file
_STRAIN = 0.01  # of the weakest section, where the scene only says that a record is played
SIMULATED, WALL = "simulated time", "the wall clock"
"""Time bases."""
_NEAR = NANOSECONDS // 2  # between a stamp and its time base
_IN_LOCKSTEP = NANOSECONDS  # a command may be for several frames


class CommandError(DrillTwinError):
    """A command that is not followed.

    Attributes:
        kind: Word by which refusals are counted.
    """

    def __init__(self, kind: str, reason: str) -> None:
        super().__init__(reason)
        self.kind = kind


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

    def check(self, command: Command) -> None:
        """Check the set-points that a command has.

        Raises:
            CommandError: A set-point is infinite or outside its range.
        """
        checks = (
            ("weight on bit", command.weight_on_bit, self.weight_on_bit, 1.0, "N"),
            ("top-drive speed", command.rotation, self.rotation, math.tau, "rev/s"),
            ("speed of the block", command.block, self.block, 1.0, "m/s"),
        )
        for name, value, (low, high), unit, symbol in checks:
            if low <= value <= high or math.isnan(value):
                continue
            found = f"found {value / unit:g} {symbol}"
            if math.isinf(value):
                raise CommandError("not_finite", f"{name}: expected a finite number, {found}")
            expected = f"expected {low / unit:g} to {high / unit:g} {symbol}"
            raise CommandError("out_of_range", f"{name}: {expected}, {found}")

    def without_block(self, command: Command) -> tuple[Command, str]:
        """The command without a speed of the block that is not followed, and a sentence on the speed unless it is 0."""
        rests = command.block == 0.0 and not math.isnan(command.weight_on_bit)
        if not self.block_not_followed or math.isnan(command.block) or rests:
            return command, ""
        told = (
            f"speed of the block: expected none, since {self.block_not_followed}, found {command.block:g} m/s; "
            "the other set-points are followed"
        )
        without = command._replace(block=math.nan if math.isnan(command.weight_on_bit) else 0.0)
        return without, told if command.block else ""


def limits_for(scene: Scene, settings: SimpleNamespace) -> CommandLimits:
    """The limits of a scene; its own set-points are always within them.

    Args:
        scene: Scene.
        settings: Parameters of the simulator. `max_weight_on_bit` [N] of 0 is ten times the scene's largest and at
            least 100 N, or where a record is played what strains the weakest section by 1 %; `max_speed` [rad/s] of 0
            is ten times the scene's largest and at least 10 rev/s, or where a record is played 100 rev/s.
            `negative_commands` says whether tension and left-hand rotation may be commanded although the scene does
            neither and plays no record.
    """
    rig, negative = scene.rig, settings.negative_commands
    weight = settings.max_weight_on_bit or _largest(rig.weight_on_bit, _LEAST_WEIGHT, _strained(scene))
    speed = settings.max_speed or _largest(rig.rotation, _LEAST_SPEED, FASTEST)
    not_followed = "the scene has no `rig.block`"
    if rig.block is not None:
        not_followed = "the auto-driller moves it" if rig.block.auto_driller else ""
    return CommandLimits(
        weight_on_bit=_range(rig.weight_on_bit, weight, negative=negative),
        rotation=_range(rig.rotation, speed, negative=negative),
        block_not_followed=not_followed,
    )


def _largest(planned: SetPoint, least: float, recorded: float) -> float:
    if planned.shape == "table":
        return recorded
    return max(_GENEROUS * abs(planned.value), _GENEROUS * abs(planned.initial), least)


def _strained(scene: Scene) -> float:
    return min(
        _STRAIN * section.youngs_modulus * 0.25 * math.pi * (section.outer_diameter**2 - section.inner_diameter**2)
        for section in scene.string.sections
    )


def _range(planned: SetPoint, largest: float, *, negative: bool) -> tuple[float, float]:
    low, high = min(0.0, planned.value, planned.initial), max(largest, planned.value, planned.initial)
    negative = negative or low < 0.0 or planned.shape == "table"  # a measured standstill wavers around zero
    return (min(low, -largest) if negative else low), high


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
                f"stamp: expected {kept}, as this source began with, found {base}; keep to {kept}, or stamp zero",
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
