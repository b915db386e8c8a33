# SPDX-License-Identifier: Apache-2.0
"""The public Python API, re-exported by `drill_twin`: scenes, runs, results, analysis (docs/api.md)."""

from drill_twin.api.ensemble import Ensemble
from drill_twin.api.estimator import Estimator
from drill_twin.api.maps import operating_map
from drill_twin.api.parameter_fit import fit
from drill_twin.api.recorded_run import Rerun, rerun
from drill_twin.api.results.result import Cost, Result, read_bag
from drill_twin.api.results.whirl import Whirl, analyze
from drill_twin.api.rotordynamics import branches, campbell, growth_map, modes, whirl_states
from drill_twin.api.scenes import build_scene, check_scene, load_scene, override, scene_names, write_scene
from drill_twin.api.simulation import Simulation, State
from drill_twin.api.torque_drag import statics
from drill_twin.core.errors import (
    ArgumentError,
    BagError,
    CheckpointError,
    DrillTwinError,
    MessageError,
    RunError,
    SceneError,
    StoppedError,
    TableError,
)
from drill_twin.runs.ensemble import EnsembleResult
from drill_twin.scene import Scene
from drill_twin.studies.estimation import Estimate, EstimatorOptions
from drill_twin.studies.fitting import Posterior, Record, read_record
from drill_twin.studies.maps import OperatingMap, Regime, read_map
from drill_twin.whirl import AnalysisError, MotionState, Onset, Summary

__all__ = [
    "AnalysisError",
    "ArgumentError",
    "BagError",
    "CheckpointError",
    "Cost",
    "DrillTwinError",
    "Ensemble",
    "EnsembleResult",
    "Estimate",
    "Estimator",
    "EstimatorOptions",
    "MessageError",
    "MotionState",
    "Onset",
    "OperatingMap",
    "Posterior",
    "Record",
    "Regime",
    "Rerun",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "State",
    "StoppedError",
    "Summary",
    "TableError",
    "Whirl",
    "analyze",
    "branches",
    "build_scene",
    "campbell",
    "check_scene",
    "fit",
    "growth_map",
    "load_scene",
    "modes",
    "operating_map",
    "override",
    "read_bag",
    "read_map",
    "read_record",
    "rerun",
    "scene_names",
    "statics",
    "whirl_states",
    "write_scene",
]
