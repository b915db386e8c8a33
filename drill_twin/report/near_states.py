# SPDX-License-Identifier: Apache-2.0
"""Steady whirls near the findings of a bag.

`drill_twin.dynamics.rotordynamics` finds the states under weight and rotation at the end of the bag, in the lateral
form.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.rotordynamics.campbell import growth_map
from drill_twin.dynamics.rotordynamics.equations import TIME_DEPENDENT, EquationsOfMotion, without
from drill_twin.dynamics.rotordynamics.steady.refinement import refined
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.dynamics.rotordynamics.steady.whirl_states import SPATIAL_EFFECTS, lateral_form, search
from drill_twin.report.recording import Recording
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

EVALUATIONS = 150_000
"""Of the equations, after which the search for states ends: half a minute of a core on a mesh of 24 elements."""
ELEMENTS = 24
"""Most elements of the mesh on which states are computed."""
LAST = 1.0 / 3.0
"""Share of a bag, at its end, that gives the set-points."""
NEAR = 0.02
"""Largest difference between the frequencies of a finding and of a state near it, over the rotation."""


def near_states(bag: Recording, summary: dict[str, Any]) -> dict[str, Any]:
    """States and the findings near them, in plain types, for the key `whirl_states` of a summary.

    Args:
        bag: A recording.
        summary: Summary of the recording (`drill_twin.report.summary.summarise`).

    Returns:
        By key: `weight_on_bit_n`, `rotation_rev_s`; `axis_growth_per_s`, the growth of the string on the axis [1/s];
        `states`; `findings`, each with a sentence and the number of its state; `notes`. Only `notes`
        where no steady whirl can exist.
    """
    notes: list[str] = []
    try:
        scene, command = _lateral(bag, notes), _command(bag)
        equations = EquationsOfMotion(scene)
        found = search(equations, command, evaluations=EVALUATIONS)
        states = tuple(_checked(scene, state) for state in found.states)
        axis = growth_map(equations, np.array([command.weight_on_bit]), np.array([command.rotation])).lateral[0, 0]
    except (SceneError, RunError) as error:
        return {"notes": [f"no whirl states: {error}"]}
    if not found.is_whole:
        notes.append(f"the search for states was cut short after {EVALUATIONS:,} evaluations: others may exist")
    findings = [_placed(name, frequency, command, states) for name, frequency in _frequencies(summary)]
    return {
        "weight_on_bit_n": command.weight_on_bit,
        "rotation_rev_s": command.rotation / math.tau,
        "axis_growth_per_s": float(axis),
        "states": [
            {"kind": state.kind, "frequency_hz": state.frequency, "ratio": state.ratio, **state.stability()}
            for state in states
        ],
        "findings": findings,
        "notes": notes,
    }


def _lateral(bag: Recording, notes: list[str]) -> Scene:
    """The bag's scene in the lateral form on a mesh that is not too fine, without what depends on time."""
    if not bag.scene_known:
        raise SceneError("expected a bag whose scene is known, found another; give it with --scene")
    scene = bag.scene
    shaken = [key for key in scene.effect_names if key in TIME_DEPENDENT]
    finest = min(ELEMENTS, bag.nodes - 1) if bag.nodes else ELEMENTS
    own = lateral_form(without(scene, shaken), finest)
    if left_out := [key for key in scene.effect_names if key not in {*own.effect_names, *SPATIAL_EFFECTS}]:
        notes.append(f"states are computed without {', '.join(left_out)}")
    return own


def _checked(scene: Scene, state: WhirlState) -> WhirlState:
    """A state with the whirl speed of the run's mesh, the growth of finer ones, and the difference of both meshes."""
    fine = refined(scene, state)
    change = max(fine.growth_change, abs(fine.growth - state.growth))
    return replace(state, spectrum=fine.spectrum, growth_change=change, lost_at=fine.lost_at)


def _command(bag: Recording) -> Command:
    """Mean weight on bit and rotation over the last part of the bag."""
    if not len(bag.rig):
        raise SceneError("expected weight on bit and rotation in the bag (/rig/state), found none")
    time = bag.rig.time
    last = time >= time[-1] - LAST * (time[-1] - time[0])
    weight, rotation = bag.rig.bit_force[last], bag.rig.top_drive_speed[last]
    if not np.isfinite(weight).any():
        raise SceneError("expected the weight on bit in the bag (/rig/state), found none")
    return Command(float(np.nanmean(weight)), float(np.nanmean(rotation)))


def _frequencies(summary: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """Findings that are frequencies [Hz]."""
    if summary["whirl_frequency_hz"] is not None:
        yield "whirl frequency", summary["whirl_frequency_hz"]
    for line in summary["spectrum_lines"] or ():
        yield f"line of the spectrum, {line['frequency_hz']:+.2f} Hz", line["frequency_hz"]


def _placed(name: str, frequency: float, command: Command, states: tuple[WhirlState, ...]) -> dict[str, Any]:
    """A finding with the state that it is near."""
    nearest = min(range(len(states)), key=lambda k: abs(states[k].frequency - frequency), default=None)
    found: dict[str, Any] = {"finding": name, "frequency_hz": frequency, "state": None}
    rotation = command.rotation / math.tau
    if nearest is not None and abs(states[nearest].frequency - frequency) < NEAR * abs(rotation):
        state = states[nearest]
        what = f"the {state.kind} whirl at {state.frequency:+.3f} Hz"
        sentence = _leaves(state.growth, what, state.growth_frequency)
        if state.verdict not in {"stable", "unstable"}:
            sentence = (
                f"{what}, whose stability is not determined: finer meshes change the sign of its growth, or lose it"
            )
        return found | {"state": nearest, "sentence": f"near {sentence}"}
    if abs(frequency - rotation) < NEAR * abs(rotation):
        return found | {"sentence": "at the rotation: bow and eccentricity turn with it"}
    if nearest is None:
        return found | {"sentence": "no steady whirl was found"}
    return found | {"sentence": f"near no steady whirl; the nearest is at {states[nearest].frequency:+.3f} Hz"}


def _leaves(growth: float, what: str, frequency: float = 0.0) -> str:
    """Growth or decay of a state in words."""
    at = f", oscillating at {frequency:.2f} Hz in its frame" if frequency > 0.0 else ""
    if growth < 0.0:
        return f"{what}, stable: the slowest disturbance decays at {-growth:.3g} 1/s{at}"
    return f"{what}, unstable: the fastest disturbance grows at {growth:.3g} 1/s{at}"
