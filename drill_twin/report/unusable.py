# SPDX-License-Identifier: Apache-2.0
"""Sentences on a bag that cannot be analysed: no scene, no samples."""

from __future__ import annotations

import math
from pathlib import Path

from drill_twin.io.bag.reader import Bag
from drill_twin.io.downhole import readings_topic
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TWIN_SCENE
from drill_twin.report.selection import Selection
from drill_twin.whirl.downhole import WAITING


def no_scene(path: Path, trouble: str, *, of_sub: bool) -> str:
    """Sentence on a bag without a usable scene.

    Args:
        path: Path of the bag.
        trouble: Reason why its scene cannot be used; empty without one.
        of_sub: The trouble is one with the readings of a sub.
    """
    if trouble:
        unused = "" if of_sub else f"expected a scene on {TWIN_SCENE}, found one that cannot be used: "
        return f"{path}: {unused}{trouble}"
    return (
        f"{path}: expected the scene on {TWIN_SCENE}, found no message there; "
        "name the scene with --scene, or give --clearance"
    )


def no_samples(bag: Bag, selection: Selection, sub: str, trouble: str) -> str:
    """Sentence on a bag, or a part of it, in which nothing can be analysed; `trouble` is the last reason for that."""
    needed = (readings_topic(sub),) if sub else (MARKS_STATE, RIG_STATE)
    counts = ", ".join(f"{bag.topics[one].count if one in bag.topics else 0} on {one}" for one in needed)
    why = f" ({trouble})" if trouble else ""
    if (selection.begin, selection.end) != (-math.inf, math.inf):
        why += f", none of them from {selection.begin:g} s to {selection.end:g} s; choose another --from and --to"
    wanted = f"readings of {sub}" if sub else "marks and rig states with the same stamps"
    return f"{bag.path}: expected {wanted} to analyse, found {counts}{why}"


def no_rotation(path: Path, sub: str) -> str:
    """Sentence on a bag whose samples do not tell the rotation, without which whirl is not defined."""
    if sub:
        return f"{path}: expected revolutions of a sub at a steady speed, found {WAITING}"
    return (
        f"{path}: expected the rotation, as top_drive on {RIG_STATE} or as the spin of the marks, "
        "found neither; without rotation whirl is not defined"
    )
