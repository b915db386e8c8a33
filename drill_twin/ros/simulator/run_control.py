# SPDX-License-Identifier: Apache-2.0
"""Control of a run, and its services: pause, resume, step, reset, checkpoints.

Our own services are `std_srvs/Trigger`, so any tool calls them. ROS has no service with a number among its common
types; how many frames a step takes is therefore the parameter `step_frames`, which shows its value and its range.
Where the package `simulation_interfaces` is installed, the services that simulators of ROS have in common call the same
control: a stopped run is a paused one at time zero. What is unsupported (spawning, worlds, part of a reset) is answered
as such.
"""

import importlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from std_srvs.srv import Trigger

from drill_twin.core.errors import CheckpointError, DrillTwinError
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.requests import Answer, Later
from drill_twin.ros.simulator.simulation import SimulatorRun

# simulation_interfaces/Result and SimulationState, by number: their names have changed between versions.
UNSUPPORTED, OK, INCORRECT_STATE, FAILED = 0, 1, 3, 4
ALREADY = 101  # SetSimulationState: in the wanted state already
STOPPED, PLAYING, PAUSED, QUITTING = 0, 1, 2, 3
_WHOLE = (0, 255)  # scopes of ResetSimulation: default and all
_RESET, _PAUSE, _SINGLE, _MULTIPLE = 10, 14, 15, 16  # SimulatorFeatures

SERVICES = (
    *("get_simulation_state", "set_simulation_state", "step_simulation", "reset_simulation"),
    "get_simulator_features",
)
"""Names under the node; a type is its name in capitals, as `GetSimulationState`."""

Told = Callable[[bool, str], object]
"""Called with whether all frames of a step were taken, and a sentence on them."""


class RunControl:
    """Control of one simulation: the one way to let time stand still, whoever asks for it."""

    def __init__(self, simulation: SimulatorRun, node: TwinNode) -> None:
        """Start not paused.

        Args:
            simulation: The run.
            node: The simulator.
        """
        self.simulation, self._node, self._settings = simulation, node, node.settings
        self._node_name = node.get_fully_qualified_name()
        self.paused = False
        """True while the run is paused."""
        self.steps = 0
        """Frames of a step that are still to be taken."""
        self._step_of = 0  # frames in all
        self._told: Told | None = None

    @property
    def runs(self) -> bool:
        """True while the next frame may be computed."""
        return self._node.active and (self.steps > 0 or not (self.paused or self.simulation.waits_for_command))

    @property
    def state(self) -> int:
        """State by the numbers of simulation_interfaces: stopped is paused before the first frame."""
        if self._node.active and not self.paused:
            return PLAYING
        return PAUSED if self.simulation.loop.frames else STOPPED

    @property
    def state_text(self) -> str:
        """The state in a word: running, waiting (for commands), paused or inactive."""
        if not self._node.active or self.paused:
            return "paused" if self._node.active else "inactive"
        # In lockstep a run waits within every frame; it stands still once commands have stopped coming.
        commands = self.simulation.commands
        silent = any(quantity.silent for quantity in commands.quantities) or not commands.heard
        return "waiting" if silent and self.simulation.waits_for_command else "running"

    def quit(self) -> str:
        """End the node."""
        self._node.end()
        return "ending"

    def pause(self) -> str:
        """Stop simulated time."""
        self.end_steps("the run was paused")
        self.paused = True
        return f"paused at {self.simulation.time_text}"

    def resume(self) -> str:
        """Let simulated time go on."""
        self.end_steps("the run was resumed")
        self.paused = False
        return f"running from {self.simulation.time_text}"

    def take_frames(self, count: int, told: Told) -> None:
        """Advance a paused run by frames, one in each turn of the loop, so that all else is answered meanwhile.

        Raises:
            DrillTwinError: The run is inactive, is not paused, is in lockstep, or is taking a step.
        """
        if self.steps or count < 1 or not self._node.active:
            found = (
                f"a run taking {self.steps}" if self.steps else f"{count} frames of a node that is {self.state_text}"
            )
            raise DrillTwinError(
                f"expected a step of one frame or more of an active run that stands still, found {found}"
            )
        if not self.paused:
            raise DrillTwinError(
                f"expected a paused run to step, found a run in progress; call {self._node_name}/pause first"
            )
        if self._settings.pace == "lockstep":
            raise DrillTwinError(
                "expected the pace realtime or fast to step by hand, found lockstep, where each command is a step; "
                f"call {self._node_name}/resume and send commands one by one"
            )
        self.steps, self._step_of, self._told = count, count, told

    def frame_taken(self) -> None:
        """Count a frame of a step; the last one is told."""
        if self.steps and self._told is not None:
            self.steps -= 1
            if not self.steps:
                frames = f"{self._step_of} frame{'s' if self._step_of > 1 else ''}"
                self._told(True, f"{frames} on, at {self.simulation.time_text}")

    def end_steps(self, why: str) -> None:
        """Leave the rest of a step undone, and tell it."""
        if self.steps and self._told is not None:
            taken, self.steps = self._step_of - self.steps, 0
            at = self.simulation.time_text
            self._told(False, f"expected {self._step_of} frames, took {taken}, to {at}, as {why} meanwhile")

    def reset(self) -> str:
        """Start a new run at time zero."""
        self.end_steps("it was reset")
        self.simulation.reset()
        return f"began again at {self.simulation.time_text}"

    def save_checkpoint(self) -> str:
        """Write the state to a file that the periodic checkpoint does not overwrite."""
        path = self._checkpoint_path()
        self.simulation.checkpoint().save(path)
        return f"kept {self.simulation.time_text} in {path}"

    def load_checkpoint(self) -> str:
        """Go to the state in the file of `save_checkpoint`."""
        path = self._checkpoint_path()
        self.end_steps("a checkpoint was loaded")
        self.simulation.resume(path)
        self.simulation.loop.announce()
        return f"went to {self.simulation.time_text}, from {path}"

    def _checkpoint_path(self) -> Path:
        own, periodic = self._settings.saved_checkpoint, self._settings.checkpoint
        file = own or (periodic and str(Path(periodic).with_name(f"{Path(periodic).stem}_saved.npz")))
        if not file or (periodic and Path(file).resolve() == Path(periodic).resolve()):
            raise CheckpointError(
                f"expected another file than the periodic checkpoint, found {file or 'none'}; "
                f"ros2 param set {self._node_name} saved_checkpoint FILE.npz"
            )
        return self.simulation.places.file(file)


# --- services --------------------------------------------------------------------------------------------------------


class Answers:
    """An answer for each service; `simulation_interfaces` defines requests and responses."""

    def __init__(self, run: RunControl) -> None:
        self._run = run

    def get_simulation_state(self, _: Any, response: Any) -> Any:
        """Stopped, playing or paused."""
        response.state.state = self._run.state
        return _said(response, OK)

    def set_simulation_state(self, request: Any, response: Any) -> Any:
        """Play, pause, stop (pause at time zero) or quit."""
        wanted, run = request.state.state, self._run
        actions = {PLAYING: run.resume, PAUSED: run.pause, STOPPED: self._stop, QUITTING: run.quit}
        if wanted == run.state:
            return _said(response, ALREADY)
        if wanted not in actions:
            return _said(response, UNSUPPORTED, f"expected a state from 0 to 3, found {wanted}")
        return _answered(actions[wanted], partial(_done, response))

    def _stop(self) -> str:
        self._run.pause()
        return self._run.reset()

    def step_simulation(self, request: Any, response: Any) -> Any:
        """Advance by the requested frames; the answer comes when the frames are out."""
        if self._run.state == PLAYING:
            return _said(response, INCORRECT_STATE, "expected a paused run to step, found a run that plays")
        return _after_step(self._run, int(request.steps), partial(_done, response))

    def reset_simulation(self, request: Any, response: Any) -> Any:
        """Begin again; time and state belong together."""
        if getattr(request, "scope", 0) not in _WHOLE:
            return _said(response, UNSUPPORTED, f"expected scope 0 or 255, all of it, found {request.scope}")
        return _answered(self._run.reset, partial(_done, response))

    def get_simulator_features(self, _: Any, response: Any) -> Any:
        """Supported features of the package."""
        response.features.features = [_RESET, _PAUSE, _SINGLE, _MULTIPLE]
        response.features.custom_info = "drill_twin: a step is one published frame"
        return response


def _said(response: Any, result: int, text: str = "") -> Any:
    response.result.result, response.result.error_message = result, text
    return response


def _done(response: Any, success: bool, text: str) -> Any:
    return _said(response, OK) if success else _said(response, FAILED, text)


def _answered(action: Callable[[], str], response_of: Callable[[bool, str], Any]) -> Any:
    """Response to an action, which says what it did, or raises a DrillTwinError; `response_of` is as `Told`."""
    try:
        return response_of(True, action())
    except DrillTwinError as error:
        return response_of(False, str(error))


def _after_step(run: RunControl, count: int, response_of: Callable[[bool, str], Any]) -> Any:
    """Answer to a step, sent once its frames are out, or something has ended it; `response_of` is as `Told`."""
    later = Later()
    try:
        run.take_frames(count, lambda done, text: later.send(response_of(done, text)))
    except DrillTwinError as error:
        return response_of(False, str(error))
    return later


def offer(node: TwinNode, run: RunControl) -> None:
    """Offer the services of a run: one for each action, and `simulation_interfaces`' services where it is installed."""
    for action in (run.pause, run.resume, run.reset, run.save_checkpoint, run.load_checkpoint):
        node.create_service(Trigger, f"~/{action.__name__}", _answering(node, partial(_answered, action)))
    take_frames = lambda told: _after_step(run, node.settings.step_frames, told)  # noqa: E731 - they may change
    node.create_service(Trigger, "~/step", _answering(node, take_frames))
    try:
        kinds = importlib.import_module("simulation_interfaces.srv")
    except ImportError:
        return
    for name in SERVICES:
        kind = getattr(kinds, name.title().replace("_", ""))
        node.create_service(kind, f"~/{name}", getattr(Answers(run), name))


def _answering(node: TwinNode, answered: Callable[[Callable[[bool, str], Any]], Any]) -> Answer:
    return lambda _, response: answered(partial(_filled, node, response))


def _filled(node: TwinNode, response: Trigger.Response, success: bool, text: str) -> Trigger.Response:
    """Fill a response, and log what it says."""
    response.success, response.message = success, text
    if success:  # rclpy refuses two severities from one line
        node.get_logger().info(text)
    else:
        node.get_logger().warning(text)
    return response
