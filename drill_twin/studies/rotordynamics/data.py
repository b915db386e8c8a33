# SPDX-License-Identifier: Apache-2.0
"""Results of the rotordynamics as plain types for JSON."""

from __future__ import annotations

import cmath
import math
from typing import Any

from drill_twin.dynamics.rotordynamics.campbell import Campbell
from drill_twin.dynamics.rotordynamics.growth_map import GrowthMap
from drill_twin.dynamics.rotordynamics.modes import ModeTable
from drill_twin.dynamics.rotordynamics.steady.branches import Branch
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.studies.rotordynamics.simulated import SimulatedWhirl


def modes_data(table: ModeTable) -> dict[str, Any]:
    """Set-points and modes; frequencies in Hz, growth in 1/s."""
    command = table.balance.command
    return {
        "weight_on_bit_n": command.weight_on_bit,
        "rotation_rev_s": command.rotation / math.tau,
        "on_axis": table.on_axis,
        "growing": table.growing,
        "slowest_decay_without_oscillation_per_s": table.creeping,
        "modes": [
            {
                "kind": mode.kind,
                "number": mode.number,
                "frequency_hz": mode.frequency,
                "growth_per_s": mode.growth,
                "damping_ratio": mode.damping_ratio,
                "frequency_change_hz": None if cmath.isnan(mode.change) else mode.change.imag / math.tau,
                "growth_change_per_s": None if cmath.isnan(mode.change) else mode.change.real,
                "shape_real": mode.shape.real.tolist(),
                "shape_imaginary": mode.shape.imag.tolist(),
            }
            for mode in table.modes
        ],
    }


def campbell_data(diagram: Campbell) -> dict[str, Any]:
    """Frequencies [Hz] and growth [1/s] by speed, then mode; critical speeds [rev/s]."""
    return {
        "weight_on_bit_n": diagram.weight_on_bit,
        "rotation_rev_s": (diagram.speeds / math.tau).tolist(),
        "frequency_hz": (diagram.eigenvalues.imag / math.tau).tolist(),
        "growth_per_s": diagram.eigenvalues.real.tolist(),
        "critical": [{"mode": mode + 1, "rotation_rev_s": speed / math.tau} for mode, speed in diagram.critical],
    }


def growth_data(growth: GrowthMap) -> dict[str, Any]:
    """Growth [1/s] by load, then speed, and the least loads with growth above zero [N]."""
    data: dict[str, Any] = {
        "weight_on_bit_n": growth.weights.tolist(),
        "rotation_rev_s": (growth.speeds / math.tau).tolist(),
        "lateral_growth_per_s": growth.lateral.tolist(),
        "whirl_onset_n": growth.onset(growth.lateral).tolist(),
    }
    if growth.torsional is not None:
        data["torsional_growth_per_s"] = growth.torsional.tolist()
        data["stick_slip_onset_n"] = growth.onset(growth.torsional).tolist()
    return data


def state_data(state: WhirlState, modulated: float | None = None) -> dict[str, Any]:
    """A steady whirl: set-points, frequency [Hz], growth [1/s], contact, shape in the turning frame [m].

    Args:
        state: The state.
        modulated: Size of its modulation by bow and eccentricity [m]; None for a state locked to the rotation.
    """
    command = state.whirl.command
    return {
        "weight_on_bit_n": command.weight_on_bit,
        "rotation_rev_s": command.rotation / math.tau,
        "kind": state.kind,
        "frequency_hz": state.frequency,
        "ratio": state.ratio,
        **state.stability(),
        "slip": state.slip,
        "touching": state.touching,
        "modulation_m": modulated,
        "x_m": state.whirl.u[:, 0].tolist(),
        "y_m": state.whirl.u[:, 1].tolist(),
    }


def branch_data(branch: Branch) -> dict[str, Any]:
    """Frequencies [Hz], ratios, growth [1/s] along a branch, its folds and Hopf points, and why it ends; SI values."""
    return {
        "parameter": branch.parameter,
        "values": branch.values.tolist(),
        "frequency_hz": [state.frequency for state in branch.states],
        "ratio": [state.ratio for state in branch.states],
        "growth_per_s": [state.growth for state in branch.states],
        "stable": [state.is_stable for state in branch.states],
        "kind": [state.kind for state in branch.states],
        "folds": [float(branch.values[k]) for k in branch.folds],
        "hopf": [float(branch.values[k]) for k in branch.hopf],
        "ends": list(branch.ends),
    }


def run_data(value: float, run: SimulatedWhirl) -> dict[str, Any]:
    """Whirl of a run in time at a value of the parameter (SI)."""
    numbers = {"frequency_hz": run.frequency, "ratio": run.ratio, "scatter": run.scatter, "change": run.change}
    return {"value": value, "steady": run.is_steady, **numbers}
