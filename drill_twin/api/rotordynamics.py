# SPDX-License-Identifier: Apache-2.0
"""Modes, critical speeds, growth rates and steady whirl of a scene without a run."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from numpy.typing import ArrayLike

from drill_twin.api.result_views import CampbellDiagram, GrowthPlane, Modes
from drill_twin.api.scenes import Overrides, as_scene, points_of, range_of, with_resolution
from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError, SceneError
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE
from drill_twin.dynamics.discretisation.kernel_arguments import SPATIAL, form_of
from drill_twin.dynamics.discretisation.resolution import LONG
from drill_twin.dynamics.rotordynamics import campbell as _campbell
from drill_twin.dynamics.rotordynamics import modes as _modes
from drill_twin.dynamics.rotordynamics.assembly import Assembly, Extent
from drill_twin.dynamics.rotordynamics.assembly_modes import table_of
from drill_twin.dynamics.rotordynamics.equations import (
    TIME_DEPENDENT,
    EquationsOfMotion,
    meshed,
    moving_everywhere,
    without,
)
from drill_twin.dynamics.rotordynamics.forced_response import ForcedResponse
from drill_twin.dynamics.rotordynamics.forced_response import forced_response as _forced_response
from drill_twin.dynamics.rotordynamics.modes import LATERAL, ModeTable, Resting
from drill_twin.dynamics.rotordynamics.steady import branches as _branches
from drill_twin.dynamics.rotordynamics.steady import whirl_states as _whirl_states
from drill_twin.dynamics.rotordynamics.steady.branches import Branch
from drill_twin.dynamics.rotordynamics.steady.imperfections import Modulation, locked_states, modulation
from drill_twin.dynamics.rotordynamics.steady.refinement import refined_states
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.dynamics.torque_drag.sliding_balance import SlidingBalance
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.scene import Scene
from drill_twin.scene.overrides import full_key
from drill_twin.scene.schema import number_at
from drill_twin.scene.set_points import Command

MOST_COMPARED, MOST_AT_REST = 3500, 500
"""Unknowns of the finer mesh up to which modes are compared with it; less where a balance on the wall is sought."""


def steady_scene(scene: Scene | str | Path, overrides: Overrides | None, left_out: Sequence[str]) -> Scene:
    """The scene under its final set-points, without some of its effects.

    Raises:
        SceneError: The scene plays a record, which has no final set-points, or an effect is not listed.
    """
    own = without(as_scene(scene, overrides), left_out)
    if recorded := [key for key in ("weight_on_bit", "rotation") if getattr(own.rig, key).shape == "table"]:
        raise SceneError(
            f"{own.name}: expected set-points with a final value, found a recorded {' and '.join(recorded)}, which "
            f"changes; {' '.join(f'--set rig.{key}.shape=constant --set rig.{key}.value=...' for key in recorded)} "
            "replaces it"
        )
    return moving_everywhere(with_resolution(own))


def final_command(scene: Scene) -> Command:
    """Final weight on bit and rotation of a scene."""
    return Command(scene.rig.weight_on_bit.value, scene.rig.rotation.value)


def resting_in(equations: EquationsOfMotion) -> Resting:
    """Function from a command to a balance under it, to start from: the balance of `rig.start: equilibrium`."""

    def resting(command: Command) -> Array:
        from drill_twin.dynamics.twin.dynamics import Dynamics

        held = held_at(equations.scene, command, start="equilibrium")
        return Dynamics(held, equations.model.rod).unknowns[0].copy()

    return resting


def held_at(scene: Scene, command: Command, **rig: object) -> Scene:
    """The scene under constant weight on bit and rotation, with other fields of its rig."""
    for key, value in (("weight_on_bit", command.weight_on_bit), ("rotation", command.rotation)):
        rig[key] = getattr(scene.rig, key).model_copy(update={"shape": "constant", "initial": value, "value": value})
    return scene.model_copy(update={"rig": scene.rig.model_copy(update=rig)})


def modes_under(scene: Scene, command: Command) -> ModeTable:
    """Modes of a scene under constant set-points on its own mesh, without effects that depend on time.

    Raises:
        SceneError: The scene has no modes.
        RunError: There is no balance.
    """
    left_out = [key for key in scene.effect_names if key in TIME_DEPENDENT]
    return modes(held_at(scene, command), without=left_out, is_compared=False)


def fastest_of(command: Command) -> float:
    """Rotation up to which critical speeds and responses are sought: twice the scene's rotation [rad/s]."""
    return 2.0 * (abs(command.rotation) or 10.0)


def _sliding(equations: EquationsOfMotion, command: Command, guess: Array | None = None) -> Array:
    """Balance of a long string that turns on bottom."""
    operation = Operation("turning", command.weight_on_bit, 0.0, command.rotation)
    return SlidingBalance(equations).solve(operation, guess).u


def forced_response(scene: Scene, table: ModeTable) -> ForcedResponse:
    """Response to mass unbalance and to a bend over the speed of rotation, up to twice the scene's speed.

    Args:
        scene: A scene of `steady_scene`.
        table: Modes of the scene.
    """
    command, whole = table.balance.command, Extent(scene.length, scene.length)
    assembly = table.assembly or Assembly(EquationsOfMotion(scene), command, table.balance.u, whole)
    return _forced_response(assembly, [mode for mode in table.of(LATERAL) if mode.frequency > 0.0], fastest_of(command))


def modes(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    count: int = _modes.COUNT,
    is_compared: bool = True,
) -> Modes:
    """Damped modes of the string, turning in balance under the final set-points of a scene.

    Each mode is computed on a mesh twice as fine too, unless the fine mesh has too many unknowns: its `change`. Of a
    long string (1,000 m and more, its weight at the bit) the lateral modes are its assembly's modes on the low side
    (`drill_twin.dynamics.rotordynamics.assembly`).

    >>> table = modes("pa6_bench", {"wob": 5, "rpm": 120})
    >>> [(mode.kind, mode.frequency, mode.growth) for mode in table.modes]

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace the scene's values.
        without: Effects to leave out.
        count: Modes of each kind.
        is_compared: False leaves out the finer mesh, which takes most of the time.

    Raises:
        SceneError: The scene cannot be loaded, or an effect of it depends on time.
        RunError: There is no balance.
    """
    own = steady_scene(scene, overrides, without)
    command = final_command(own)
    if own.length >= LONG and form_of(own) == SPATIAL and own.rig.weight_on_bit.at == "bit":
        return Modes(*table_of(own, command, fastest_of(command), _sliding, count))
    equations = EquationsOfMotion(own)
    table = Modes(*_modes.modes(equations, command, resting_in(equations), count))
    if not is_compared:
        return table
    finer = EquationsOfMotion(meshed(own, 2 * equations.model.rod.length.size))
    if finer.unknowns <= (MOST_COMPARED if table.on_axis else MOST_AT_REST):
        with suppress(RunError):  # no balance is found on the finer mesh: the changes stay unknown
            return Modes(*_modes.compared(table, _modes.modes(finer, command, resting_in(finer), finer.unknowns)))
    return table


def campbell(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    speeds: ArrayLike | str,
    without: Sequence[str] = (),
    count: int = 6,
    numbered_at: float | None = None,
) -> CampbellDiagram:
    """Lateral modes over the speed of rotation, and critical speeds.

    >>> campbell("pa6_bench", speeds="60..390 rpm").plot()

    Arguments and errors as of `modes`; `speeds` are numbers [rad/s], shape (p,), or a range as text, of 60 points if it
    does not say ("60..390:30 rpm"); `numbered_at` is the speed [rad/s] at which the modes have the numbers of that
    table, the first if it is left out.
    """
    own = steady_scene(scene, overrides, without)
    equations, weight = EquationsOfMotion(own), own.rig.weight_on_bit.value
    turns = points_of("speeds", speeds, ANGULAR_SPEED, 60)
    return CampbellDiagram(*_campbell.campbell(equations, weight, turns, count, numbered_at))


def growth_map(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    weights: ArrayLike | str,
    speeds: ArrayLike | str,
    without: Sequence[str] = (),
    progress: Callable[[int], None] | None = None,
) -> GrowthPlane:
    """Largest growth rate over weights on bit [N], shape (w,), and speeds [rad/s], shape (p,).

    As `modes`; ranges as text ("1..80 N") have 30 points if they do not say; `progress` takes the number of loads done.

    Raises:
        ArgumentError: Weights or speeds do not increase.
    """
    loads, turns = points_of("weights", weights, FORCE, 30), points_of("speeds", speeds, ANGULAR_SPEED, 30)
    equations = EquationsOfMotion(steady_scene(scene, overrides, without))
    return GrowthPlane(*_campbell.growth_map(equations, loads, turns, progress))


def whirl_states(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    without: Sequence[str] = (),
    random_starts: int = _whirl_states.RANDOM_STARTS,
    seed: int = _whirl_states.SEED,
) -> tuple[WhirlState, ...]:
    """Steady whirl states under the final set-points of a scene, with their stability, by falling whirl speed.

    They are sought on the mesh of the scene and then computed on finer ones, which gives `growth_change` and `verdict`.

    >>> for state in whirl_states("pa6_calibrated", {"wob": 40, "rpm": 390}):
    ...     print(state.kind, state.frequency, state.growth, state.growth_change, state.verdict)

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace the scene's values.
        without: Effects to leave out.
        random_starts: Random first shapes of the search, besides the lowest modes.
        seed: Of the random shapes.

    Raises:
        SceneError: The scene cannot be loaded, or no steady whirl can exist in it.
    """
    own = steady_scene(scene, overrides, without)
    equations = EquationsOfMotion(own)
    found = _whirl_states.whirl_states(equations, final_command(own), random_starts=random_starts, seed=seed)
    return refined_states(own, found)


def imperfect_states(
    scene: Scene, states: Sequence[WhirlState]
) -> tuple[tuple[Modulation, ...], tuple[WhirlState, ...]]:
    """Modulation of each state by bow and eccentricity, to first order, and the states locked to the rotation.

    Args:
        scene: A scene of `steady_scene`.
        states: Steady whirls of the scene, on any mesh.
    """
    locked = locked_states(TurningEquations(EquationsOfMotion(scene)), final_command(scene))
    turning = {n: TurningEquations(EquationsOfMotion(meshed(scene, n))) for n in {one.elements for one in states}}
    modulations = tuple(modulation(turning[state.elements], state.whirl) for state in states)
    return modulations, refined_states(scene, locked)


def branches(
    scene: Scene | str | Path,
    overrides: Overrides | None = None,
    *,
    over: str,
    span: str | tuple[float, float],
    without: Sequence[str] = (),
    random_starts: int = _whirl_states.RANDOM_STARTS,
) -> tuple[Branch, ...]:
    """Branches of steady whirl through the states at the final set-points, one for each branch found.

    Args:
        scene: The scene, or its name or file.
        overrides: Values that replace the scene's values.
        over: `wob`, `rpm`, or the key of a number of the scene, such as `wall_friction.coefficient`.
        span: Range, such as "5..80 N" or "60..480" [rev/min], or both ends in SI.
        without: Effects to leave out.
        random_starts: As in `whirl_states`.

    Raises:
        ArgumentError: The range is none, or the key names no number.
        SceneError: The scene cannot be loaded, no steady whirl can exist in it, or its value is outside the range.
    """
    own = steady_scene(scene, overrides, without)
    equations, command = EquationsOfMotion(own), final_command(own)
    turning = TurningEquations(equations)
    low, high = range_of(own, over, span)
    makers = {"wob": (_branches.load_of, command.weight_on_bit), "rpm": (_branches.speed_of, command.rotation)}
    if over in makers:
        maker, value = makers[over]
        parameter = maker(turning, command, low, high)
    else:
        key = full_key(over, own)
        parameter, value = _branches.key_of(turning, command, key, low, high), number_at(own, key) or 0.0
    if not low < value < high:
        raise SceneError(
            f"{own.name}: expected a range of {over} around its value {value:g}, found {low:g} to {high:g}"
        )
    found: list[Branch] = []
    for state in _whirl_states.whirl_states(equations, command, random_starts=random_starts):
        if not any(_branches.passes(one, state, value) for one in found):
            found.append(_branches.branch(parameter, state.whirl, value))
    return tuple(found)
