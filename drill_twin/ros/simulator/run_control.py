# SPDX-License-Identifier: Apache-2.0
"""Control of a run by services: pause, resume, step, reset, checkpoints; each action returns a sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

from drill_twin.core.errors import CheckpointError, DrillTwinError
from drill_twin.ros.simulator.simulation import SimulatorRun
from drill_twin.ros.simulator.simulation_interfaces import PAUSED, PLAYING, STOPPED

Action = Callable[[], str]
"""Returns a sentence on what it did; raises a DrillTwinError where it cannot."""


class RunControl:
    """Control of one simulation.

    Attributes:
        active: True while the lifecycle node is active.
        paused: True while the run is paused.
        over: True once the node is to end.
    """

    def __init__(self, simulation: SimulatorRun, settings: SimpleNamespace, node_name: str) -> None:
        """Start inactive and not paused.

        Args:
            simulation: The run.
            settings: Settings of the node.
            node_name: Full name of the node, for hints.
        """
        self._simulation, self._settings, self._node_name = simulation, settings, node_name
        self.active = self.paused = self.over = False

    @property
    def runs(self) -> bool:
        """True while the next frame may be computed."""
        return self.active and not self.paused and not self.over and not self._simulation.waits_for_command

    @property
    def state(self) -> int:
        """State by the numbers of simulation_interfaces: stopped is paused before the first frame."""
        if self.active and not self.paused:
            return PLAYING
        return PAUSED if self._simulation.loop.frames else STOPPED

    @property
    def state_text(self) -> str:
        """The state in a word: running, waiting (for commands), paused or inactive."""
        if not self.active or self.paused:
            return "paused" if self.active else "inactive"
        # In lockstep a run waits within every frame; it stands still once commands have stopped coming.
        commands = self._simulation.commands.arbiter
        waits = self._simulation.waits_for_command and (commands.silent or not commands.heard)
        return "waiting" if waits else "running"

    def actions(self) -> dict[str, Action]:
        """Actions offered as services, by name."""
        offered = (self.pause, self.resume, self.step, self.reset, self.save_checkpoint, self.load_checkpoint)
        return {action.__name__: action for action in offered}

    def quit(self) -> None:
        """End the node."""
        self.over = True

    def pause(self) -> str:
        """Stop simulated time."""
        self.paused = True
        return f"paused at {self._simulation.time_text}"

    def resume(self) -> str:
        """Let simulated time go on."""
        self.paused = False
        return f"running from {self._simulation.time_text}"

    def step(self) -> str:
        """Advance by as many frames as the parameter says."""
        return self.take_frames(self._settings.step_frames)

    def take_frames(self, count: int) -> str:
        """Advance a paused run by frames, all published before the answer is sent.

        Raises:
            DrillTwinError: The run is not paused, or is in lockstep.
        """
        if not self.paused:
            raise DrillTwinError(
                f"expected a paused run to step, found one that runs; call {self._node_name}/pause first"
            )
        if self._settings.pace == "lockstep":
            raise DrillTwinError(
                "expected the pace realtime or fast to step by hand, found lockstep, where each command is a step; "
                f"call {self._node_name}/resume and send commands one by one"
            )
        for _ in range(count):
            self._simulation.advance()
        return f"{count} frame{'s' if count > 1 else ''} on, at {self._simulation.time_text}"

    def reset(self) -> str:
        """Start a new run at time zero."""
        self._simulation.reset()
        return f"began again at {self._simulation.time_text}"

    def save_checkpoint(self) -> str:
        """Write the state to a file that the periodic checkpoint does not overwrite."""
        path = self._checkpoint_path()
        self._simulation.checkpoint().save(path)
        return f"kept {self._simulation.time_text} in {path}"

    def load_checkpoint(self) -> str:
        """Go to the state in the file of `save_checkpoint`."""
        path = self._checkpoint_path()
        self._simulation.resume(path)
        self._simulation.loop.announce()
        return f"went to {self._simulation.time_text}, from {path}"

    def _checkpoint_path(self) -> str:
        own, periodic = self._settings.saved_checkpoint, self._settings.checkpoint
        if own and periodic and Path(own).resolve() == Path(periodic).resolve():
            raise CheckpointError(
                f"expected another file than the periodic checkpoint, found {own} for both; "
                f"ros2 param set {self._node_name} saved_checkpoint FILE.npz"
            )
        if own or periodic:
            return str(own or Path(periodic).with_name(f"{Path(periodic).stem}_saved.npz"))
        raise CheckpointError(
            "expected a file for the checkpoint, found none; "
            f"ros2 param set {self._node_name} saved_checkpoint FILE.npz"
        )
