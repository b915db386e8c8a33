# SPDX-License-Identifier: Apache-2.0
"""Files saved when a run fails: a checkpoint of the last good frame, the last second of states, and the error."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drill_twin.core.errors import CheckpointError, StoppedError
from drill_twin.core.files.whole_file import whole_file, write_whole
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command

CHECKPOINT, LAST_SECOND, REASON = "checkpoint.npz", "last_second.npz", "why.txt"


def save_failure(folder: str | Path, twin: Twin, command: Command, error: StoppedError) -> str:
    """Write `checkpoint.npz`, `last_second.npz` (`time`, `u`, `v`, `distance_from_bit`) and `why.txt`.

    Args:
        folder: Target folder; created if it is missing.
        twin: The twin, restored to its last good frame.
        command: The set-points in force.
        error: The reason of the stop.

    Returns:
        A sentence that names the folder, or the error if the files could not be written; it never raises for those, so
        that the reason of the stop is not hidden.
    """
    target = Path(folder)
    try:
        Checkpoint.of(twin, command).save(target / CHECKPOINT)
        time, u, v = twin.last_second()
        with whole_file(target / LAST_SECOND) as stream:
            np.savez(stream, time=time, u=u, v=v, distance_from_bit=twin.rod.arc)
        write_whole(target / REASON, f"{error}\n")
    except (CheckpointError, OSError) as trouble:
        return f"the state could not be kept: {trouble}"
    return f"the last good state and the last second before it are kept in {target}"
