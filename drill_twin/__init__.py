# SPDX-License-Identifier: Apache-2.0
"""A digital twin of a flexible drillstring as a ROS 2 node set, and its Python API.

>>> import drill_twin as dt
>>> result = dt.Simulation("pa6_bench").run(duration=30)
>>> result.onset_s

Names of the API are loaded on first use, so that a node that needs one module does not load them all.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from drill_twin.core.version import __version__

if TYPE_CHECKING:
    from drill_twin.api import (
        AnalysisError,
        ArgumentError,
        BagError,
        CheckpointError,
        Cost,
        DrillTwinError,
        Ensemble,
        EnsembleResult,
        Estimate,
        Estimator,
        EstimatorOptions,
        MessageError,
        MotionState,
        Onset,
        OperatingMap,
        Posterior,
        Record,
        Regime,
        Rerun,
        Result,
        RunError,
        Scene,
        SceneError,
        Simulation,
        State,
        StoppedError,
        Summary,
        TableError,
        Whirl,
        analyze,
        branches,
        build_scene,
        campbell,
        check_scene,
        fit,
        growth_map,
        load_scene,
        modes,
        operating_map,
        override,
        read_bag,
        read_map,
        read_record,
        rerun,
        scene_names,
        statics,
        whirl_states,
        write_scene,
    )

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
    "__version__",
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


def __getattr__(name: str) -> Any:
    """Load a name of the API on first use."""
    if name.startswith("__") or name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module("drill_twin.api"), name)
    return value


def __dir__() -> list[str]:
    """Names of the API, loaded or not."""
    return sorted({*globals(), *__all__})
