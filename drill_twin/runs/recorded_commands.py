# SPDX-License-Identifier: Apache-2.0
"""Set-points of a recorded run, one for each frame: what the rig commanded or, without commands, its state."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from drill_twin.core.errors import BagError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointStateReader, read_float64
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE, RPS_COMMAND, WOB_COMMAND
from drill_twin.scene.set_points.command import Command

_LEAST_FRAMES = 2


@dataclass(frozen=True)
class RecordedCommands:
    """Set-points at the end of each frame of a run, from its first frame on."""

    source: str
    """Topics that they were taken from, in words."""
    period: int
    """Length of a frame [ns]."""
    commands: list[Command]
    """One for each frame."""
    known_from: float
    """Simulated time from which the bag holds them [s]; before, they are those of the scene."""


def recorded_commands(bag: Bag, planned: Callable[[float], Command], *, block: bool) -> RecordedCommands:
    """Set-points of the last run in a bag.

    A command whose stamp is the end of a frame belongs to that frame, as in lockstep; any other holds from the frame
    that was recorded after it. Without `/rig/command` the single values are taken, and without those the weight on bit
    and the speeds of top drive and block in `/rig/state`.

    Args:
        bag: The bag.
        planned: Set-points of the scene at a time [s], for the frames before the first command.
        block: The scene has a block whose speed is a set-point; else that in `/rig/state` is what came of the others.

    Raises:
        BagError: It has no rig states.
    """
    by_driver = _count(bag, RIG_COMMAND) > 0
    by_hand = not by_driver and _count(bag, WOB_COMMAND) + _count(bag, RPS_COMMAND) > 0
    reading = _Reading(planned(0.0), by_driver=by_driver, by_hand=by_hand, block=block)
    for topic, _, raw in bag.messages((RIG_COMMAND, WOB_COMMAND, RPS_COMMAND, RIG_STATE)):
        reading.take(topic, raw)
    stamps = sorted(reading.held)
    if len(stamps) < _LEAST_FRAMES:
        raise BagError(
            f"{bag.path}: expected frames on {RIG_STATE} to run again, found {len(stamps)}; record that topic too"
        )
    period = round(float(np.median(np.diff(stamps))))
    commanded = [stamp for stamp, command in (reading.held | reading.stamped).items() if command and stamp > 0]
    known = min(commanded, default=stamps[-1] + period)
    commands, last = [], planned(0.0)
    for frame in range(1, round(stamps[-1] / period) + 1):
        stamp = frame * period
        if stamp < known - period // 2:
            last = planned(seconds(stamp))
        else:
            last = reading.stamped.get(stamp) or reading.held.get(stamp) or last
        commands.append(last)
    return RecordedCommands(reading.source, period, commands, seconds(known) if known > 1.5 * period else 0.0)


@dataclass
class _Reading:
    """Set-points by the stamps of commands, and those in force when each frame was recorded."""

    now: Command
    by_driver: bool
    by_hand: bool
    block: bool
    stamped: dict[int, Command] = field(default_factory=dict)
    held: dict[int, Command | None] = field(default_factory=dict)
    """None before the first command."""
    _commands: JointStateReader = field(default_factory=JointStateReader)
    _states: JointStateReader = field(default_factory=JointStateReader)
    _last: int = -1
    _heard: bool = False

    @property
    def source(self) -> str:
        if self.by_driver:
            return RIG_COMMAND
        return f"{WOB_COMMAND} and {RPS_COMMAND}" if self.by_hand else f"{RIG_STATE}, as measured"

    def take(self, topic: str, raw: bytes) -> None:
        """Take a message; one that cannot be used is left out, as by the simulator."""
        try:
            if topic == RIG_STATE:
                self._on_state(raw)
            elif topic == RIG_COMMAND:
                state = self._commands.read(raw)
                self._on_command(read_command(state, 0.0 if self.block else None), state.stamp)
            elif self.by_hand and topic == WOB_COMMAND:
                self._on_command(replace(self.now, weight_on_bit=read_float64(raw)))
            elif self.by_hand:
                self._on_command(replace(self.now, rotation=read_float64(raw) * math.tau))
        except MessageError:
            return

    def _on_command(self, command: Command, stamp: int | None = None) -> None:
        self.now, self._heard = (given := command.completed(self.now)), True
        if stamp is not None:
            self.stamped[stamp] = given

    def _on_state(self, raw: bytes) -> None:
        state = self._states.read(raw)
        if state.stamp < self._last:  # a new run
            self.held.clear()
        self._last = state.stamp
        if not (self.by_driver or self.by_hand) and state.effort.size and state.velocity.size:
            measured = read_command(state)
            self._on_command(measured if self.block else replace(measured, block=0.0))
        self.held[state.stamp] = self.now if self._heard else None


def _count(bag: Bag, topic: str) -> int:
    return bag.topics[topic].count if topic in bag.topics else 0
