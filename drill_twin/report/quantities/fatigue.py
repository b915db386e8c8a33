# SPDX-License-Identifier: Apache-2.0
"""Stress and fatigue damage of a run at the sections of the effect `fatigue`."""

from __future__ import annotations

import numpy as np

from drill_twin.report.recording import Recording


def fatigue(bag: Recording) -> dict[str, dict[str, float | None]] | None:
    """By section: stress, cycles and damage of the run; None without the effect.

    Keys: `distance_from_bit_m`, `largest_stress_pa` and its `share_of_yield`, `largest_moment_nm`, `axial_force_n`
    (mean, positive = tension), `cycles`, `damage`; and for the second half of the run, where the motion has settled,
    `cycles_per_second` and `seconds_to_damage_1`: the whole life at its rate of damage, None without any.
    """
    block = bag.scene.effects.fatigue if bag.scene_known else None
    if block is None or not len(bag.stress):
        return None
    found, strengths = bag.stress, block.yield_strengths(bag.scene)
    places = {section.name: section.distance(bag.scene.length) for section in block.sections}
    middle = int(np.searchsorted(found.time, 0.5 * (found.time[0] + found.time[-1])))
    seconds = float(found.time[-1] - found.time[middle])
    moment = np.hypot(found.moment_x, found.moment_y).max(axis=0)
    rows = {}
    for number, name in enumerate(found.names):
        damage, cycles = found.damage[:, number], found.cycles[:, number]
        late = float(damage[-1] - damage[middle])
        largest = float(found.largest_stress[-1, number])
        rows[name] = {
            "distance_from_bit_m": places[name],
            "largest_stress_pa": largest,
            "share_of_yield": largest / strengths[name],
            "largest_moment_nm": float(moment[number]),
            "axial_force_n": float(found.axial_force[:, number].mean()),
            "cycles": float(cycles[-1]),
            "damage": float(damage[-1]),
            "cycles_per_second": float(cycles[-1] - cycles[middle]) / seconds if seconds > 0.0 else None,
            "seconds_to_damage_1": seconds / late if late > 0.0 else None,
        }
    return rows
