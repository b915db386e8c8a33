# SPDX-License-Identifier: Apache-2.0
"""Error and processor time of growth rates and whirl states over elements, beside the simulation in time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drill_twin.api.rotordynamics import final_command, steady_scene
from drill_twin.base.arrays import Array
from drill_twin.errors import RunError
from drill_twin.rotordynamics.equations import EquationsOfMotion, meshed
from drill_twin.rotordynamics.growth_map import growth_map
from drill_twin.rotordynamics.steady.refinement import on_mesh
from drill_twin.rotordynamics.steady.steady_whirl import TurningEquations, Whirl
from drill_twin.rotordynamics.steady.whirl_states import whirl_states
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.studies.rotordynamics.simulated import simulated_whirl

SEARCHED, REFERENCE = 16, 3
"""Elements of the search for the state, and elements of the reference over the finest mesh of the study."""
REPEATS, MAP = 7, 10
"""Repetitions of a timing, of which the least counts, and loads and speeds of the timed map."""
WARM = 0.99
"""Load of the state from which Newton's method starts, over the scene's."""


@dataclass(frozen=True)
class Cost:
    """Errors and processor time of one mesh; errors relative to the finest mesh."""

    elements: int
    ratio: float
    """Whirl speed of the state over the rotation."""
    ratio_error: float
    state_ms: float
    """Newton's method from the state at a load 1 % lower."""
    growth: float
    """Growth of the state's fastest disturbance [1/s]."""
    growth_error: float
    stability_ms: float
    axis_growth: float
    """Largest growth of the string on the axis [1/s]."""
    axis_error: float
    map_ms: float
    """A point of a map of growth rates."""
    run_error: float | None
    """Error of the whirl speed of a run in time; None: not run."""
    run_ms: float | None


def whirl_cost(
    scene: Scene, elements: Sequence[int], *, runs: bool = True, progress: Callable[[int], None] = lambda _: None
) -> Iterator[Cost]:
    """Costs over meshes, of the state whose disturbances decay fastest at the scene's set-points.

    Args:
        scene: Scene with a wall in a straight vertical hole.
        elements: Meshes; the reference has `REFERENCE` times the largest.
        runs: Run each mesh in time too.
        progress: Called with the number of meshes done.

    Raises:
        RunError: No state is found, or it is lost on a mesh.
        SceneError: No steady whirl can exist in the scene.
    """
    own = steady_scene(scene, None, ())
    command = final_command(own)
    states = whirl_states(_equations(own, SEARCHED), command)
    if not states:
        raise RunError(f"{own.name}: expected a steady whirl at the scene's set-points, found none; take others")
    found = min(states, key=lambda state: state.growth).whirl
    arc = _equations(own, SEARCHED).model.rod.arc
    finest = _measured(_equations(own, REFERENCE * max(elements)), found, arc, 1)
    for number, count in enumerate(elements):
        one = _measured(_equations(own, count), found, arc, REPEATS)
        run_error, run_ms = None, None
        if runs:
            begun = time.process_time()
            run = simulated_whirl(meshed(own, count))
            run_error, run_ms = _error(run.ratio, finest.ratio), 1e3 * (time.process_time() - begun)
        progress(number + 1)
        yield Cost(
            count, one.ratio, _error(one.ratio, finest.ratio), one.state_ms, one.growth,
            _error(one.growth, finest.growth), one.stability_ms, one.axis_growth,
            _error(one.axis_growth, finest.axis_growth), one.map_ms, run_error, run_ms,
        )  # fmt: skip


def _measured(equations: EquationsOfMotion, found: Whirl, arc: Array, repeats: int) -> Cost:
    """Values and times of one mesh, errors zero."""
    turning, command = TurningEquations(equations), found.command
    at_own = turning.newton(on_mesh(equations, found, arc)) or _nearest(equations, found)
    lower = Command(WARM * command.weight_on_bit, command.rotation)
    near = at_own and turning.newton(replace(at_own, command=lower))
    start = near and replace(near, command=command)
    whirl = start and turning.newton(start)
    if start is None or whirl is None:
        raise RunError(
            f"expected the state of {SEARCHED} elements with {equations.model.rod.length.size} too, found none; "
            "take set-points farther from the end of its branch (drill-twin whirl-states --over)"
        )
    growth = float(turning.spectrum(whirl)[0].real)
    weights = command.weight_on_bit * np.linspace(0.1, 1.0, MAP)
    speeds = command.rotation * np.linspace(0.1, 1.0, MAP)
    axis = float(growth_map(equations, weights[-1:], speeds[-1:]).lateral[0, 0])
    return Cost(
        equations.model.rod.length.size, whirl.omega / command.rotation, 0.0,
        least_ms(lambda: turning.newton(start), repeats), growth, 0.0,
        least_ms(lambda: turning.spectrum(whirl), repeats), axis, 0.0,
        least_ms(lambda: growth_map(equations, weights, speeds), min(repeats, 2)) / MAP**2, None, None,
    )  # fmt: skip


def _equations(scene: Scene, elements: int) -> EquationsOfMotion:
    return EquationsOfMotion(meshed(scene, elements))


def _nearest(equations: EquationsOfMotion, found: Whirl) -> Whirl | None:
    """State of a mesh with the whirl speed nearest to that of another mesh."""
    whirls = (state.whirl for state in whirl_states(equations, found.command))
    return min(whirls, key=lambda whirl: abs(whirl.omega - found.omega), default=None)


def _error(value: float, reference: float) -> float:
    return abs(value / reference - 1.0)


def least_ms(work: Callable[[], object], repeats: int) -> float:
    """Least processor time of some repetitions [ms]."""
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return 1e3 * min(times)
