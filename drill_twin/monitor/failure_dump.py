# SPDX-License-Identifier: Apache-2.0
"""What is kept of a run that was stopped: a checkpoint of the last good frame, and the last second of states."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drill_twin.errors import CheckpointError, StoppedError
from drill_twin.schedule.command import Command
from drill_twin.twin.checkpoint import Checkpoint
from drill_twin.twin.twin import Twin

CHECKPOINT, LAST_SECOND, WHY = "checkpoint.npz", "last_second.npz", "why.txt"


def save_failure(folder: str | Path, twin: Twin, command: Command, error: StoppedError) -> str:
    """Write `checkpoint.npz`, `last_second.npz` (`time`, `u`, `v`, `distance_from_bit`) and `why.txt`.

    Args:
        folder: Where to; made if it is not there.
        twin: The twin, back at its last good frame.
        command: The set-points that were in force.
        error: Why it was stopped.

    Returns:
        What was kept and where, in words; or why nothing could be kept: a full disk does not hide the stop.
    """
    target = Path(folder)
    try:
        Checkpoint.of(twin, command).save(target / CHECKPOINT)
        time, u, v = twin.last_second()
        np.savez(target / LAST_SECOND, time=time, u=u, v=v, distance_from_bit=twin.rod.arc)
        (target / WHY).write_text(f"{error}\n", encoding="utf-8")
    except (CheckpointError, OSError) as trouble:
        return f"the state could not be kept: {trouble}"
    return f"the last good state and the last second before it are kept in {target}"
