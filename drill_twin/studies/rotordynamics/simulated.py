# SPDX-License-Identifier: Apache-2.0
"""Whirl speed of a simulation in time, to be compared with steady states."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.parts import parts_of, planned
from drill_twin.scene import Scene
from drill_twin.scene.load import build_scene
from drill_twin.scene.set_points import Command

LAST = 1.0 / 3.0
"""Share of the run, at its end, that is measured."""
WINDOWS = 5
STEADY = 0.02
"""Of a steady whirl: largest scatter of the whirl speed between windows, over the rotation, and largest change of the
shape, over the clearance."""


class SimulatedWhirl(NamedTuple):
    """Mean whirl at the end of a run."""

    command: Command
    frequency: float
    """Mean whirl frequency of the mark with the largest radius [Hz]."""
    ratio: float
    """Over the rotation [-]."""
    scatter: float
    """Standard deviation of the frequency between windows, over the rotation [-]."""

    change: float
    """Root mean square of the motion of the marks in the frame of that whirl, the largest, over the clearance [-]."""

    @property
    def is_steady(self) -> bool:
        """True if the whirl speed is the same in all windows, and the shape turns with it unchanged."""
        return max(self.scatter, self.change) < STEADY


def with_command(scene: Scene, weight: float, rotation: float) -> Scene:
    """The scene with other final set-points [N], [rad/s]."""
    values: dict[str, float | str] = {"rig.weight_on_bit.value": weight, "rig.rotation.value": rotation}
    return build_scene(scene.model_dump(mode="json", exclude_none=True), name=scene.name, overrides=values)


def simulated_whirl(scene: Scene) -> SimulatedWhirl:
    """Run a scene to its end, and measure the whirl over its last third.

    Raises:
        RunError: The motion could not be followed.
    """
    commands, frame = planned(scene)
    places = (part.rows.centre for part in parts_of(Twin(scene), commands, frame))
    path = np.concatenate([centre[..., 0] + 1j * centre[..., 1] for centre in places])
    path = path[max(int(len(path) * (1.0 - LAST)) - 1, 0) :]
    mark = int(np.argmax(np.mean(np.abs(path), axis=0)))
    angle = np.unwrap(np.angle(path[:, mark]))
    edges = np.linspace(0, angle.size - 1, WINDOWS + 1).astype(int)
    rates = np.diff(angle[edges]) / (np.diff(edges) * frame)
    mean = float((angle[-1] - angle[0]) / ((angle.size - 1) * frame))
    command = Command(scene.rig.weight_on_bit.value, scene.rig.rotation.value)
    turned = path * np.exp(-1j * angle)[:, None]
    change = float(np.sqrt(np.mean(np.abs(turned - turned.mean(axis=0)) ** 2, axis=0)).max()) / scene.least_clearance
    scatter = float(rates.std()) / abs(command.rotation)
    return SimulatedWhirl(command, mean / math.tau, mean / command.rotation, scatter, change)
