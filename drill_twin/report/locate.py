# SPDX-License-Identifier: Apache-2.0
"""Where a bag lies, what its texts say of the run, and what is said of a bag that cannot be analysed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TWIN_SCENE
from drill_twin.io.whirl_pipeline import WhirlPipeline


def bag_in(path: str | Path) -> Path:
    """The bag of a run's folder (`out/run` -> `out/run/bag_0`); any other path as it is."""
    folder = Path(path)
    inside = folder / "bag_0"
    return inside if inside.is_dir() and not [*folder.glob("*.mcap"), *folder.glob("*.db3")] else folder


def run_block(text: str) -> dict[str, Any]:
    """The `run` block of a scene text; empty where there is none."""
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError:
        return {}  # the pipeline has said what is wrong with the scene
    run = data.get("run") if isinstance(data, dict) else None
    return dict(run) if isinstance(run, dict) else {}


def finite_number(text: str) -> float | None:
    """The number that a text is, if it is finite."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def no_scene(bag: Bag, trouble: str) -> str:
    """Why there is no scene to analyse the bag with, in words."""
    if trouble:
        return f"{bag.path}: expected a scene on {TWIN_SCENE}, found one that cannot be used: {trouble}"
    return (
        f"{bag.path}: expected the scene on {TWIN_SCENE}, found no message there; "
        "name the scene with --scene, or give --clearance"
    )


def no_samples(bag: Bag, pipeline: WhirlPipeline) -> str:
    """Why there is nothing to analyse, in words."""
    counts = ", ".join(
        f"{bag.topics[topic].count if topic in bag.topics else 0} on {topic}" for topic in (MARKS_STATE, RIG_STATE)
    )
    why = f" ({pipeline.trouble})" if pipeline.trouble else ""
    return f"{bag.path}: expected marks and rig states with the same stamps to analyse, found {counts}{why}"
