# SPDX-License-Identifier: Apache-2.0
"""The services that simulators of ROS have in common (`simulation_interfaces`), where that package is installed.

They say the same as our own: a stopped run is a paused one at time zero. What is unsupported (spawning, worlds, part of
a reset) is answered as such.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.node import Node
from rclpy.service import Service

from drill_twin.core.errors import DrillTwinError

# simulation_interfaces/Result and SimulationState, by number: their names have changed between versions.
UNSUPPORTED, OK, INCORRECT_STATE, FAILED = 0, 1, 3, 4
ALREADY = 101  # SetSimulationState: in the wanted state already
STOPPED, PLAYING, PAUSED, QUITTING = 0, 1, 2, 3
_WHOLE = (0, 255)  # scopes of ResetSimulation: default and all
_RESET, _PAUSE, _SINGLE, _MULTIPLE = 10, 14, 15, 16  # SimulatorFeatures

SERVICES = {
    "get_simulation_state": "GetSimulationState",
    "set_simulation_state": "SetSimulationState",
    "step_simulation": "StepSimulation",
    "reset_simulation": "ResetSimulation",
    "get_simulator_features": "GetSimulatorFeatures",
}
"""Names under the node and types."""


class ControlledRun(Protocol):
    """A run that the services control."""

    @property
    def state(self) -> int:
        """STOPPED, PLAYING or PAUSED."""

    def pause(self) -> str:
        """Stop simulated time."""

    def resume(self) -> str:
        """Let simulated time go on."""

    def reset(self) -> str:
        """Start a new run at time zero."""

    def take_frames(self, count: int) -> str:
        """Take frames of a paused run."""

    def quit(self) -> None:
        """End the node."""


class Answers:
    """An answer for each service; requests and responses are those of the package."""

    def __init__(self, run: ControlledRun) -> None:
        self._run = run

    def get_simulation_state(self, request: Any, response: Any) -> Any:
        """Stopped, playing or paused."""
        del request
        response.state.state = self._run.state
        return _said(response, OK)

    def set_simulation_state(self, request: Any, response: Any) -> Any:
        """Play, pause, stop (pause at time zero) or quit."""
        wanted = request.state.state
        if wanted == self._run.state:
            return _said(response, ALREADY)
        if wanted == QUITTING:
            self._run.quit()
            return _said(response, OK)
        actions: dict[int, tuple[Callable[[], str], ...]] = {
            PLAYING: (self._run.resume,),
            PAUSED: (self._run.pause,),
            STOPPED: (self._run.pause, self._run.reset),
        }
        if wanted not in actions:
            return _said(response, UNSUPPORTED, f"expected a state from 0 to 3, found {wanted}")
        return _done(response, *actions[wanted])

    def step_simulation(self, request: Any, response: Any) -> Any:
        """So many frames on; the answer comes when they are out."""
        if self._run.state == PLAYING:
            return _said(response, INCORRECT_STATE, "expected a paused run to step, found one that plays")
        return _done(response, lambda: self._run.take_frames(int(request.steps)))

    def reset_simulation(self, request: Any, response: Any) -> Any:
        """Begin again; time and state belong together."""
        if getattr(request, "scope", 0) not in _WHOLE:
            return _said(response, UNSUPPORTED, f"expected scope 0 or 255, all of it, found {request.scope}")
        return _done(response, self._run.reset)

    def get_simulator_features(self, request: Any, response: Any) -> Any:
        """Supported features of the package."""
        del request
        response.features.features = [_RESET, _PAUSE, _SINGLE, _MULTIPLE]
        response.features.custom_info = "drill_twin: a step is one published frame"
        return response


def _said(response: Any, result: int, text: str = "") -> Any:
    response.result.result, response.result.error_message = result, text
    return response


def _done(response: Any, *actions: Callable[[], str]) -> Any:
    try:
        for action in actions:
            action()
    except DrillTwinError as error:
        return _said(response, FAILED, str(error))
    return _said(response, OK)


def offer_where_installed(node: Node, run: ControlledRun) -> list[Service]:
    """The services of the package; none where it is not installed."""
    try:
        kinds = importlib.import_module("simulation_interfaces.srv")
    except ImportError:
        return []
    answers = Answers(run)
    return [
        node.create_service(getattr(kinds, kind), f"~/{name}", getattr(answers, name))
        for name, kind in SERVICES.items()
    ]
