# SPDX-License-Identifier: Apache-2.0
"""Messages of the command topics: checked for their stamps and their publishers, and handed to the arbiter."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.rig_messages import read_command
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import RIG_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.simulator.command_arbiter import CommandArbiter, Silence
from drill_twin.ros.simulator.command_limits import limits_for
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

_AHEAD = 1_000_000_000  # ns; a command stamped later than this is not for the frames to come
_WINDOW = 5.0  # s
_TURNS = 2


class PublisherCheck:
    """Sequence numbers of the messages of one topic, by which more than one publisher is noticed.

    DDS does not tell a Python subscriber who sent a message, but each publisher counts its own: one publisher's
    numbers only grow; the numbers of two that send in turn go back again and again. A publisher started anew sends
    numbers that go back once.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = -1
        self._turns: deque[float] = deque(maxlen=_TURNS)

    def take(self, number: int) -> bool:
        """Take the number of the next message; returns True where it is the first to show that several send."""
        before, back, self._last = self.several_send, number <= self._last, number
        if back:
            self._turns.append(self._clock())
        return back and not before and self.several_send

    @property
    def several_send(self) -> bool:
        """True while the numbers went back more than once in the last seconds."""
        return len(self._turns) == _TURNS and self._clock() - self._turns[0] < _WINDOW


class CommandInput:
    """Callbacks of the command topics of a simulator, and the arbiter of what they bring.

    Attributes:
        arbiter: Checks the commands and holds the set-point.
    """

    def __init__(self, node: TwinNode, scene: Scene, first: Command, now: Callable[[], float]) -> None:
        """Create the arbiter.

        Args:
            node: The simulator.
            scene: The scene; it limits the commands.
            first: Set-points before the first command.
            now: Simulated time [s].
        """
        self._node, self._scene, self._first, self._now = node, scene, first, now
        self._read_command = JointStateReader().read
        self._went_back = False
        self._publishers = PublisherCheck()
        self.arbiter = CommandArbiter(*self._rules(), first)

    def apply_settings(self) -> None:
        """Apply the limits in the node's settings."""
        self.arbiter.set_limits(*self._rules())

    def reset(self, command: Command | None = None) -> None:
        """Start anew, as time went back, or to a checkpoint with this command in force; what is under way is older."""
        self.arbiter.begin(self._first)
        self._went_back = True
        if command is not None:
            self.arbiter.resume(command)

    def rivals(self) -> list[str]:
        """Names of the publishers of `/rig/command` where more than one sends as the commander: the set-points flip."""
        return self._node.topics.publisher_nodes(RIG_COMMAND) if self._publishers.several_send else []

    def _rules(self) -> tuple[Any, Silence]:
        settings: SimpleNamespace = self._node.settings
        limits = limits_for(
            self._scene,
            max_weight_on_bit=settings.max_weight_on_bit,
            max_speed=settings.max_speed,
            negative=settings.negative_commands,
        )
        safe = Command(settings.safe_weight_on_bit, settings.safe_speed)
        follows = settings.on_silence
        return limits, Silence(
            settings.command_timeout,
            ramp=follows == "ramp",
            ramp_if_lost=follows == "ramp_if_lost",
            safe=safe,
            ramp_time=settings.safe_ramp_time,
        )

    def on_command(self, raw: bytes, info: Mapping[str, Any]) -> None:
        """Take a message of `/rig/command`."""
        try:
            state = self._read_command(raw)
            command = read_command(state, absent_weight=0.0 if self._scene.rig.moves_block else None)
        except MessageError as error:
            self.arbiter.malformed(str(error))
            return
        ahead = state.stamp - stamp_ns(self._now())
        if ahead > _AHEAD:
            if self._went_back:  # it was under way when time went back
                return
            if self._node.settings.pace == "lockstep":  # it would set free all frames until then
                self.arbiter.malformed(
                    f"expected a command stamped for the next frames, found one {ahead * 1e-9:g} s ahead"
                )
                return
        self._went_back = False
        ours = self.arbiter.command(state.stamp, command, state.frame_id)
        if ours and self._publishers.take(info["publication_sequence_number"]):
            self._node.publish_diagnostics()
