# SPDX-License-Identifier: Apache-2.0
"""Cases of a comparison: a scene with changes, which is run, or a bag."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from drill_twin.api.results.result import Result, read_bag
from drill_twin.api.scenes import load_scene
from drill_twin.api.simulation import Simulation
from drill_twin.api.torque_drag import statics
from drill_twin.core.errors import ArgumentError, RunError, SceneError
from drill_twin.dynamics.torque_drag.analysis import OperationLoads
from drill_twin.scene import Scene

ALIASES = {"rpm": "rig.rotation.value"}
"""Names of changes beside the short ones of every override."""
_CHANGE = re.compile(r",\s*(?=[A-Za-z_][\w.]*=)")


@dataclass(frozen=True, eq=False)
class Case:
    """Case: its run, and its loads without a run."""

    name: str
    result: Result
    loads: OperationLoads | None
    """Of the last operation of its rig, drilling or what there is of it; None if there is no balance."""


def prepare(text: str, common: Mapping[str, str]) -> Scene | Result:
    """Read a case: the scene of `SCENE[,KEY=VALUE...]`, not yet run, or the result of a bag.

    Args:
        text: A scene with changes (`wob`, `rpm` or any key of a scene), or the folder or file of a bag.
        common: Changes of all cases that are run.

    Raises:
        ArgumentError: A change of a bag.
        SceneError: No such scene, or a change that does not fit.
        BagError: No bag of this package.
    """
    base, *changes = _CHANGE.split(text)
    pairs = (change.split("=", 1) for change in changes)
    own = {ALIASES.get(key, key): value for key, value in pairs}
    path = Path(base)
    if path.is_dir() or path.suffix in {".mcap", ".db3"}:
        if own:
            raise ArgumentError(
                f"{text}: expected a bag without changes, found {', '.join(own)}; a run is over. Name its scene "
                "instead, or use drill-twin rerun"
            )
        return read_bag(path)
    return load_scene(base, {**common, **own})


def finish(text: str, what: Scene | Result, progress: Callable[[float], None] | None = None) -> Case:
    """Run a scene, if it is one, and find its loads in a balance.

    Raises:
        RunError: The run stops early.
    """
    result = what
    if isinstance(result, Scene):
        result = Simulation(result).run(progress=(lambda state: progress(state.time)) if progress else None)
    try:
        loads = statics(result.scene).operations[-1]
    except (RunError, SceneError):  # no balance, or nothing to balance: the run is compared alone
        loads = None
    return Case(text, result, loads)
