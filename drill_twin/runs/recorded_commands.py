# SPDX-License-Identifier: Apache-2.0
"""Set-points of a recorded run, one for each frame: what the rig commanded or, without commands, its state."""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from drill_twin.core.errors import BagError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointStateReader, read_float64
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE, RPS_COMMAND, WOB_COMMAND
from drill_twin.scene.set_points.command import Command

COMMANDS = ((RIG_COMMAND,), (WOB_COMMAND, RPS_COMMAND))
"""Topics of set-points; the first group that a bag has is taken."""
_LEAST_FRAMES = 2


@dataclass(frozen=True)
class RecordedCommands:
    """Set-points at the end of each frame of a run, from its first frame on."""

    source: str
    """Topics of the set-points, in words."""
    period: int
    """Length of a frame [ns]."""
    commands: list[Command]
    """One for each frame."""
    known_from: float
    """Simulated time from which the set-points come from the bag [s]; before it they come from the scene."""


def recorded_commands(bag: Bag, planned: Callable[[float], Command], *, block: bool) -> RecordedCommands:
    """Set-points of the last run in a bag.

    A command whose stamp is the end of a frame belongs to that frame, as in lockstep; any other command holds from the
    next recorded frame on. A bag without `/rig/command` has its set-points on the topics of single values, and a bag
    without any command in the weight on bit and the speeds of top drive and block on `/rig/state`.

    Args:
        bag: The bag.
        planned: Set-points of the scene at a time [s], for the frames before the first command.
        block: True if the speed of the block is a set-point; else the speed of the block in `/rig/state` follows from
            the other set-points, and is left out.

    Raises:
        BagError: The bag has no rig states.
    """
    counts = {topic: found.count for topic, found in bag.topics.items()}
    topics = next((found for found in COMMANDS if any(counts.get(topic, 0) for topic in found)), ())
    reading = _Reading(planned(0.0), is_measured=not topics, block=block)
    for topic, _, raw in bag.messages((*topics, RIG_STATE)):
        with suppress(MessageError):  # left out, as by the simulator
            reading.take(topic, raw)
    stamps = sorted(reading.held)
    if len(stamps) < _LEAST_FRAMES:
        raise BagError(
            f"{bag.path}: expected frames on {RIG_STATE} to run again, found {len(stamps)} frames; record the topic too"
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
    source = " and ".join(topics) or f"{RIG_STATE}, as measured"
    return RecordedCommands(source, period, commands, seconds(known) if known > 1.5 * period else 0.0)


@dataclass
class _Reading:
    """Set-points by the stamps of commands, and the set-points in force when each frame was recorded."""

    now: Command
    is_measured: bool
    """The set-points are the weight and the speeds of `/rig/state`, as there are no commands."""
    block: bool
    stamped: dict[int, Command] = field(default_factory=dict)
    held: dict[int, Command | None] = field(default_factory=dict)
    """None before the first command."""
    _commands: JointStateReader = field(default_factory=JointStateReader)
    _states: JointStateReader = field(default_factory=JointStateReader)
    _last: int = -1
    _heard: bool = False

    def take(self, topic: str, raw: bytes) -> None:
        """Take a message.

        Raises:
            MessageError: The message cannot be used.
        """
        if topic == RIG_STATE:
            self._on_state(raw)
        elif topic == WOB_COMMAND:
            self._on_command(self.now._replace(weight_on_bit=read_float64(raw)))
        elif topic == RPS_COMMAND:
            self._on_command(self.now._replace(rotation=read_float64(raw) * math.tau))
        else:
            state = self._commands.read(raw)
            self._on_command(read_command(state))
            self.stamped[state.stamp] = self.now

    def _on_command(self, command: Command) -> None:
        self.now, self._heard = command.completed(self.now), True

    def _on_state(self, raw: bytes) -> None:
        state = self._states.read(raw)
        if state.stamp < self._last:  # a new run
            self.held.clear()
        self._last = state.stamp
        if self.is_measured and state.effort.size and state.velocity.size:
            measured = read_command(state)
            self._on_command(measured if self.block else measured._replace(block=0.0))
        self.held[state.stamp] = self.now if self._heard else None
