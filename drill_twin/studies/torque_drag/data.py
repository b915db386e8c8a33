# SPDX-License-Identifier: Apache-2.0
"""Loads of the operations as plain data and as a table over measured depth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drill_twin.core.table import Column, Table
from drill_twin.dynamics.torque_drag.analysis import OperationLoads, Statics
from drill_twin.dynamics.torque_drag.buckling import BucklingState
from drill_twin.studies.torque_drag.unit_system import UnitSystem


def statics_data(found: Statics) -> dict[str, Any]:
    """Numbers of each operation, SI."""
    return {"scene": found.scene.name, "operations": [_operation(loads) for loads in found.operations]}


def _operation(loads: OperationLoads) -> dict[str, Any]:
    sinusoidal, helical = loads.margins
    operation = loads.operation
    return {
        "operation": operation.name,
        "weight_on_bit_n": operation.weight_on_bit,
        "rotation_rad_s": operation.rotation,
        "axial_speed_m_s": operation.axial_speed,
        "hookload_n": loads.hookload,
        "hookload_soft_string_n": loads.soft.hookload,
        "surface_torque_nm": loads.surface_torque,
        "surface_torque_soft_string_nm": loads.soft.surface_torque,
        "bit_torque_nm": loads.bit_torque,
        "neutral_point_m": loads.neutral_point,
        "stretch_m": loads.stretch,
        "twist_rad": loads.twist,
        "sinusoidal_margin": sinusoidal,
        "helical_margin": helical,
        "buckling": loads.worst_state.label,
        "lock_up_weight_on_bit_n": loads.lock_up,
        "largest_stress_pa": float(loads.along.stress.max()),
        "yield_margin": loads.yield_margin,
        "make_up_margin": loads.make_up_margin,
        "contacts": [
            {
                "name": contact.name, "distance_from_bit_m": contact.distance_from_bit,
                "side_force_n": contact.force, "tilt_deg": math.degrees(contact.tilt),
            }
            for contact in loads.contacts
        ],
    }  # fmt: skip


def depth_table(found: Statics, units: UnitSystem) -> Table:
    """Loads along the string, a row an element from the top down, units in the headings."""
    quantities = (
        ("measured depth", "length"), ("tension", "force"), ("soft string tension", "force"), ("torque", "torque"),
        ("soft string torque", "torque"), ("side force", "force_per_length"), ("bending moment", "torque"),
        ("equivalent stress", "stress"), ("sinusoidal buckling load", "force"), ("helical buckling load", "force"),
    )  # fmt: skip
    columns = [Column("operation"), *(Column(name, getattr(units, of)) for name, of in quantities), Column("buckling")]
    rows = []
    for loads in found.operations:
        along, soft = loads.along, loads.soft
        values = np.column_stack([
            along.depth, along.tension, 0.5 * (soft.tension[1:] + soft.tension[:-1]), along.torque,
            0.5 * (soft.torque[1:] + soft.torque[:-1]), along.side_force, along.bending_moment, along.stress,
            loads.buckling.sinusoidal, loads.buckling.helical,
        ])  # fmt: skip
        for row, state in zip(values[::-1], loads.states[::-1], strict=True):
            shown = (units.show(float(value), quantity) for value, (_, quantity) in zip(row, quantities, strict=True))
            rows.append([loads.operation.name, *(f"{value:.6g}" for value in shown), BucklingState(int(state)).label])
    return Table(columns, rows)
