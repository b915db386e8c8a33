# SPDX-License-Identifier: Apache-2.0
"""Reference values of runs of the shipped scenes, with tolerances that hold on every processor.

    python test/regression/reference_values.py            # compare with reference_values.json
    python test/regression/reference_values.py --write    # after a change that is meant to alter results

Each scene of `config/scenes` runs for 10 s in each of its forms, once with its own tolerance of Newton's method and
once with the least, with the energy balance. Centre lines at the marks and the rig are kept every half second up to
`until`: the last time at which a run whose set-points differ by 1e-13 agrees within a tenth of the bound, since a
difference in the last bit grows to the size of the hole in an irregular motion.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.api import Result, Simulation
from drill_twin.scene import Scene, load_scene, presets
from drill_twin.scene.set_points import Command

FILE = Path(__file__).with_suffix(".json")
DURATION, EVERY = 10.0, 0.5  # [s]
LEAST_TOLERANCE = 1e-10
BOUND_AT_LEAST_TOLERANCE = 1e-9  # of the largest value of a column, and of the clearance
TOLERANCES = 10.0  # bound at the scene's own tolerance, in tolerances
DISTURBANCE = 1e-13
QUARTER = 0.25  # of a revolution, for an onset
REACTION = 100.0  # a reaction is a difference of positions along the string: 1e-13 m of 500 m of steel are 1e-4 N
COMPARED_WITH_RECORDS = {"ufrj_torsion", "well_b"}  # by `drill-twin study validate`
SAME_MOTION = {"bha_stress"}  # as bha_full_size
LATERAL = {"effects.stretch": "off", "effects.torsion": "off"}
TIGHT = {"numerics.tolerance": f"{LEAST_TOLERANCE:g}", "numerics.audit": "energy"}
RIG = ("top_drive_angle", "top_drive_torque", "bit_angle", "bit_speed", "bit_torque", "bit_force", "hookload")


def record() -> Path | None:
    """The public record that `ufrj_rig` plays, where it is at hand."""
    named = os.environ.get("DRILL_TWIN_DATA")
    folders = [Path(named)] if named else [Path(__file__).resolve().parents[3] / "shared" / "data"]
    found = [path for folder in folders for path in folder.rglob("175_completo_1.mat")]
    return found[0] if found else None


def cases(extra: Mapping[str, str] | None = None) -> dict[str, Scene]:
    """Scene and form -> the scene, with `extra` overrides."""
    scenes = {}
    for name in sorted(set(presets()) - COMPARED_WITH_RECORDS - SAME_MOTION):
        changes = {"rig.duration": f"{DURATION} s"} | dict(extra or {})
        if name == "ufrj_rig":
            if (table := record()) is None:
                continue
            changes["rig.table.file"] = str(table)
        scene = load_scene(name, overrides=changes)
        scenes[f"{name}/spatial"] = scene
        needing = [block for block in scene.effects.blocks.values() if {"stretch", "torsion"} & set(block.requires)]
        if not needing and scene.effects.stretch is not None:
            scenes[f"{name}/lateral"] = load_scene(name, overrides=changes | LATERAL)
    return scenes


def run(scene: Scene, disturbance: float = 0.0) -> Result:
    """Run a scene for `DURATION` with its set-points, larger by a share `disturbance`."""
    simulation, factor = Simulation(scene), 1.0 + disturbance
    if not disturbance:
        return simulation.run(DURATION)
    for _ in range(round(DURATION / simulation.frame_time)):
        command = simulation.schedule.at(simulation.time + simulation.frame_time)
        simulation.follow(Command(command.weight_on_bit * factor, command.rotation * factor, command.block))
    return simulation.result()


def columns(result: Result) -> dict[str, Any]:
    """Values every half second: name -> array, rows over time; centre lines [m], angles [rad], torques, forces."""
    rows = np.searchsorted(result.time, np.arange(EVERY, DURATION + 1e-9, EVERY) - 1e-6)
    centre = result.centre[rows]
    values = {"time": result.time[rows], "centre": centre.reshape(len(rows), -1)}
    return values | {name: getattr(result.rig, name)[rows, None] for name in RIG}


def scales(scene: Scene, values: Mapping[str, Any]) -> dict[str, float]:
    """What a column's differences are measured by: the clearance at the marks, or the largest value of its kind."""
    clearance = min(scene.clearance_at(mark.distance_from_bit) for mark in scene.string.marks)
    kinds = {name: name.removeprefix("bit_").removeprefix("top_drive_") for name in RIG} | {"hookload": "force"}
    sizes = {
        name: max(float(np.abs(values[other]).max(initial=0.0)) for other in RIG if kinds[other] == kind)
        for name, kind in kinds.items()
    }
    sizes["bit_force"] *= REACTION
    return {"centre": clearance} | {name: size or 1.0 for name, size in sizes.items()}


def errors(scene: Scene, values: Mapping[str, Any], expected: Mapping[str, Any]) -> dict[str, Any]:
    """Largest difference of each column at each time, by its scale."""
    size = scales(scene, expected)
    return {
        name: np.abs(np.asarray(values[name]) - np.asarray(expected[name])).max(axis=1) / size[name] for name in size
    }


def bound(scene: Scene, name: str) -> float:
    """Largest difference that is allowed at a tolerance, "own" or "least", as a share of a column's scale."""
    return BOUND_AT_LEAST_TOLERANCE if name == "least" else TOLERANCES * scene.tolerance


def energy(result: Result, until: float) -> dict[str, float]:
    """Energy balance at its last row up to a time [J]."""
    rows = int(np.searchsorted(result.energy.get("time", ()), until + 1e-6))
    return {name: float(values[rows - 1]) for name, values in result.energy.items()} if rows else {}


def findings(result: Result) -> dict[str, Any]:
    """Onset [s], its mark, and the motion states of the string."""
    summary = result.whirl.summary
    onset = summary.onset
    states = list(dict.fromkeys(period.state.value for period in summary.motion))
    return {"onset_s": onset and onset.time_s, "mark": onset and onset.mark, "states": states}


def reference(scene: Scene, name: str) -> dict[str, Any]:
    """Values of a run at a tolerance, with the last time up to which they hold."""
    result = run(scene)
    values, disturbed = columns(result), columns(run(scene, DISTURBANCE))
    worst = np.max(list(errors(scene, disturbed, values).values()), axis=0)
    beyond = np.flatnonzero(~(worst < 0.1 * bound(scene, name)))
    count = int(beyond[0]) if len(beyond) else len(worst)
    until = float(values["time"][count - 1]) if count else 0.0
    kept = {column: np.asarray(array)[:count].tolist() for column, array in values.items()}
    return {"until": until, "columns": kept, "energy": energy(result, until), "findings": findings(result)}


def differences(scene: Scene, name: str, expected: Mapping[str, Any]) -> list[str]:
    """What differs from the reference by more than the bound, in words."""
    result, limit = run(scene), bound(scene, name)
    values, count = columns(result), len(expected["columns"]["time"])
    if count == 0:
        return []
    shown = {column: np.asarray(array)[:count] for column, array in values.items()}
    told = [
        f"{column} at {EVERY * (1 + int(found.argmax())):g} s: {found.max():.1e} of its scale, at most {limit:.0e}"
        for column, found in errors(scene, shown, expected["columns"]).items()
        if not found.max() <= limit
    ]
    balance, scale = energy(result, expected["until"]), expected["energy"].get("scale_J", 1.0)
    told += [
        f"energy {term}: expected {value!r}, found {balance.get(term)!r} J"
        for term, value in expected["energy"].items()
        if term != "residual" and not abs(balance.get(term, np.nan) - value) <= 1e-6 * scale
    ]
    return told + _onset_differs(findings(result), expected["findings"], scene)


def _onset_differs(found: Mapping[str, Any], expected: Mapping[str, Any], scene: Scene) -> list[str]:
    """An onset is to lie within a quarter of a revolution of the reference, or to be absent as there."""
    before, now = expected["onset_s"], found["onset_s"]
    if (before is None) != (now is None) or (before is not None and abs(now - before) > QUARTER / _speed(scene)):
        return [f"onset: expected {before}, found {now} s"]
    return []


def _speed(scene: Scene) -> float:
    """Rotation of the scene [rev/s]."""
    return abs(scene.rig.rotation.value) / (2.0 * np.pi) or 1.0


def tolerances(name: str) -> dict[str, str]:
    """Overrides of the runs at a tolerance."""
    return TIGHT if name == "least" else {}


def main() -> int:
    """Compare, or write."""
    known = json.loads(FILE.read_text("utf-8")) if FILE.exists() else {}
    told: list[str] = []
    for name in ("own", "least"):
        for case, scene in cases(tolerances(name)).items():
            key = f"{case}/{name}"
            if "--write" in sys.argv:
                known[key] = reference(scene, name)
                print(f"{key}: until {known[key]['until']:g} s, {known[key]['findings']}", flush=True)
            else:
                found = differences(scene, name, known[key])
                print(f"{key}: {'as before' if not found else 'CHANGED'}", flush=True)
                told += [f"{key} {line}" for line in found]
    if "--write" in sys.argv:
        FILE.write_text(
            "{\n" + ",\n".join(f"{json.dumps(key)}: {json.dumps(known[key])}" for key in sorted(known)) + "\n}\n"
        )
    print("\n".join(told))
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main())
