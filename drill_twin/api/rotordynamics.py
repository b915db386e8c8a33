# SPDX-License-Identifier: Apache-2.0
"""Modes, critical speeds, growth rates and steady whirl of a scene without a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from drill_twin.api.scenes import Overrides, as_scene
from drill_twin.base.arrays import Array
from drill_twin.errors import ArgumentError, SceneError
from drill_twin.rotordynamics import campbell as _campbell
from drill_twin.rotordynamics import growth_map as _growth_map
from drill_twin.rotordynamics import modes as _modes
from drill_twin.rotordynamics.campbell import Campbell
from drill_twin.rotordynamics.equations import EquationsOfMotion, without
from drill_twin.rotordynamics.growth_map import GrowthMap
from drill_twin.rotordynamics.modes import ModeTable, Resting
from drill_twin.rotordynamics.steady import branches as _branches
from drill_twin.rotordynamics.steady import whirl_states as _whirl_states
from drill_twin.rotordynamics.steady.branches import Branch
from drill_twin.rotordynamics.steady.imperfections import Modulation, locked_states, modulation
from drill_twin.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.rotordynamics.steady.whirl_states import WhirlState
from drill_twin.scene import Scene
from drill_twin.scene.keys import number_at
from drill_twin.schedule import Command


def steady_scene(scene: Scene | str | Path, overrides: Overrides | None, left_out: Sequence[str]) -> Scene:
    """The scene under its final set-points, without some of its effects.

    Raises:
        SceneError: It plays a record, which has no final set-points, or an effect is not listed.
    """
    own = without(as_scene(scene, overrides), left_out)
    recorded = [key for key in ("weight_on_bit", "rotation") if getattr(own.rig, key).shape == "table"]
    if recorded:
        raise SceneError(
            f"{own.name}: expected set-points with a final value, found a recorded {' and '.join(recorded)}, which "
            f"changes; {' '.join(f'--set rig.{key}.shape=constant --set rig.{key}.value=...' for key in recorded)} "
            "replaces it"
        )
    if own.numerics.accuracy is not None:
        from drill_twin.accuracy import resolve

        own = resolve(own).scene
    return own


def final_command(scene: Scene) -> Command:
    """Final weight on bit and rotation of a scene."""
    return Command(scene.rig.weight_on_bit.value, scene.rig.rotation.value)


def resting_in(scene: Scene) -> Resting:
    """Function from a command to the static balance under it, by the search of `rig.start: equilibrium`."""

    def resting(command: Command) -> Array:
        from drill_twin.twin.dynamics import Dynamics

        rig = scene.rig
        load = rig.weight_on_bit.model_copy(update={"initial": command.weight_on_bit, "value": command.weight_on_bit})
        turn = rig.rotation.model_copy(update={"initial": command.rotation, "value": command.rotation})
        held = rig.model_copy(update={"weight_on_bit": load, "rotation": turn, "start": "equilibrium"})
        u, _ = Dynamics(scene.model_copy(update={"rig": held})).unknowns
        return u.copy()

    return resting


def modes(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    count: int = _modes.COUNT,
) -> ModeTable:
    """Damped modes of the string, turning in balance under the final set-points of a scene.

    >>> table = modes("pa6_bench", {"wob": 5, "rps": 2})
    >>> [(mode.kind, mode.frequency, mode.growth) for mode in table.modes]

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace those of the scene.
        without: Effects to leave out.
        count: Modes of each kind.

    Raises:
        SceneError: The scene cannot be loaded, or an effect of it depends on time.
        RunError: There is no balance.
    """
    own = steady_scene(scene, overrides, without)
    return _modes.modes(EquationsOfMotion(own), final_command(own), resting_in(own), count)


def campbell(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    speeds: Array,
    without: Sequence[str] = (),
    count: int = 6,
) -> Campbell:
    """Lateral modes over the speed of rotation [rad/s], shape (p,), and critical speeds.

    Arguments and errors as of `modes`.
    """
    own = steady_scene(scene, overrides, without)
    return _campbell.campbell(EquationsOfMotion(own), own.rig.weight_on_bit.value, np.asarray(speeds, float), count)


def growth_map(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    weights: Array,
    speeds: Array,
    without: Sequence[str] = (),
    progress: Callable[[int], None] | None = None,
) -> GrowthMap:
    """Largest growth rate over weights on bit [N], shape (w,), and speeds [rad/s], shape (p,).

    Arguments and errors as of `modes`; `progress` is called with the number of loads done.

    Raises:
        ArgumentError: Weights or speeds do not increase.
    """
    for name, values in (("weights", weights), ("speeds", speeds)):
        if not np.all(np.diff(np.asarray(values, float)) > 0.0):
            raise ArgumentError(f"{name}: expected values that increase, found {list(values)!s:.60}; sort them")
    own = steady_scene(scene, overrides, without)
    equations = EquationsOfMotion(own)
    return _growth_map.growth_map(equations, np.asarray(weights, float), np.asarray(speeds, float), progress)


def whirl_states(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    random_starts: int = _whirl_states.RANDOM_STARTS,
    seed: int = _whirl_states.SEED,
) -> tuple[WhirlState, ...]:
    """Steady whirl states under the final set-points of a scene, with their stability, by falling whirl speed.

    >>> lateral = {"effects.torsion": "off", "effects.stretch": "off"}
    >>> for state in whirl_states("pa6_calibrated", {"wob": 40, "rps": 6.5, **lateral}):
    ...     print(state.kind, state.frequency, state.ratio, state.is_stable)

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace those of the scene.
        without: Effects to leave out.
        random_starts: Random first shapes of the search, besides the lowest modes.
        seed: Of the random shapes.

    Raises:
        SceneError: The scene cannot be loaded, or no steady whirl can exist in it.
    """
    own = steady_scene(scene, overrides, without)
    equations = EquationsOfMotion(own)
    return _whirl_states.whirl_states(equations, final_command(own), random_starts=random_starts, seed=seed)


def imperfect_states(
    scene: Scene, states: Sequence[WhirlState]
) -> tuple[tuple[Modulation, ...], tuple[WhirlState, ...]]:
    """Modulation of each state by bow and eccentricity, to first order, and the states locked to the rotation.

    Args:
        scene: A scene of `steady_scene`.
        states: Its steady whirls.
    """
    turning = TurningEquations(EquationsOfMotion(scene))
    locked = locked_states(turning, final_command(scene))
    return tuple(modulation(turning, state.whirl) for state in states), locked


def branches(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    over: str,
    low: float,
    high: float,
    without: Sequence[str] = (),
    random_starts: int = _whirl_states.RANDOM_STARTS,
) -> tuple[Branch, ...]:
    """Branches of steady whirl through the states at the final set-points, one for each branch found.

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace those of the scene.
        over: `load` [N], `speed` [rad/s], or a key of the scene in SI, such as `effects.wall_friction.coefficient`.
        low: Least value.
        high: Largest value.
        without: Effects to leave out.
        random_starts: As in `whirl_states`.

    Raises:
        SceneError: The scene cannot be loaded, no steady whirl can exist in it, or its value is outside the range.
    """
    own = steady_scene(scene, overrides, without)
    equations, command = EquationsOfMotion(own), final_command(own)
    turning = TurningEquations(equations)
    makers = {"load": _branches.load_of, "speed": _branches.speed_of}
    if over in makers:
        parameter = makers[over](turning, command, low, high)
        value = {"load": command.weight_on_bit, "speed": command.rotation}[over]
    else:
        parameter, value = _branches.key_of(turning, command, over, low, high), _number(own, over)
    if not low < value < high:
        raise SceneError(
            f"{own.name}: expected a range of {over} around its value {value:g}, found {low:g} to {high:g}"
        )
    found: list[Branch] = []
    for state in _whirl_states.whirl_states(equations, command, random_starts=random_starts):
        if not any(_branches.passes(one, state, value) for one in found):
            found.append(_branches.branch(parameter, state.whirl, value))
    return tuple(found)


def _number(scene: Scene, key: str) -> float:
    """Value of a number of a scene."""
    found = number_at(scene, key)
    if found is None:
        raise SceneError(f"{scene.name}: expected load, speed or the key of a number of the scene, found {key}")
    return found
