# SPDX-License-Identifier: Apache-2.0
"""A run that is held in hand: pause, resume, step, reset, and its checkpoint. Each says in a sentence what it did."""

from __future__ import annotations

from typing import Any

from drill_twin.errors import CheckpointError, DrillTwinError
from drill_twin.ros.simulator.loop import Simulation
from drill_twin.ros.simulator.simulation_interfaces import PAUSED, PLAYING, STOPPED


class RunControl(Simulation):
    """What the services of a simulator do."""

    @property
    def state(self) -> int:
        """State by the numbers of simulation_interfaces: stopped is paused before the first frame."""
        if self._active and not self._paused:
            return PLAYING
        return PAUSED if self._stage.frames else STOPPED

    def quit(self) -> None:
        """End the node."""
        self._over = True

    def pause(self) -> str:
        """Let time stand still."""
        self._paused = True
        return f"paused at {self._at()}"

    def resume(self) -> str:
        """Let time run again."""
        self._paused = False
        return f"running from {self._at()}"

    def step(self) -> str:
        """Take as many frames as the parameter says."""
        return self.take_frames(self.settings.step_frames)

    def take_frames(self, count: int) -> str:
        """Take frames now, one after the other, so that they are out when the answer comes."""
        if not self._paused:
            raise DrillTwinError("expected a paused run to step, found one that runs; call ~/pause first")
        if self.settings.pace == "lockstep":
            raise DrillTwinError(
                "expected the pace realtime or fast to step by hand, found lockstep, where each command is a step; "
                "call ~/resume and send commands one by one"
            )
        for _ in range(count):
            self._advance()
        return f"{count} frame{'s' if count > 1 else ''} on, at {self._at()}"

    def reset(self) -> str:
        """Begin again at time zero, as a run of its own."""
        self._inbox.begin_again()
        self._started = False
        self._pacer.restart()
        self._stage.reset()
        return f"began again at {self._at()}"

    def save_checkpoint(self) -> str:
        """Keep the state in the file that the parameter names."""
        path = self._checkpoint_path()
        self._keeper.finish()
        self._checkpoint().save(path)
        return f"kept {self._at()} in {path}"

    def load_checkpoint(self) -> str:
        """Go to the state in that file."""
        path = self._checkpoint_path()
        self._keeper.finish()
        self._go_on_from(path, self._stage)
        self._pacer.restart()
        self._stage.announce()
        return f"went to {self._at()}, from {path}"

    def _checkpoint_path(self) -> str:
        if not self.settings.checkpoint:
            raise CheckpointError(
                "expected a file for the checkpoint, found none; ros2 param set /simulator checkpoint FILE.npz"
            )
        return str(self.settings.checkpoint)

    def _go_on_from(self, path: str, stage: Any) -> None:
        from drill_twin.twin.checkpoint import Checkpoint

        checkpoint = Checkpoint.load(path)
        if self.settings.duration and checkpoint.time >= self.settings.duration - 0.5 * self._period:
            raise CheckpointError(
                f"{path}: expected a checkpoint before the duration of {self.settings.duration:g} s, found one at "
                f"{checkpoint.time:g} s, where the run was over; move it away, or simulate for longer"
            )
        stage.go_on_from(checkpoint)
        self._inbox.begin_again(checkpoint.command)
        self.get_logger().info(f"going on from {path} at {checkpoint.time:.6g} s")
