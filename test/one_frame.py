# SPDX-License-Identifier: Apache-2.0
"""A single frame as the frames that messages are made of."""

import numpy as np

from drill_twin.dynamics.twin.frame import Frame, Frames, MarkStates


def frames_of(frame: Frame) -> Frames:
    """A single frame, as `Twin.advance` gives it, with a first axis of length one."""
    return Frames(
        time=np.array([frame.time]), positions=frame.positions[None], tangents=frame.tangents[None],
        spin=frame.spin[None], wall_force=frame.wall_force[None], wall_depth=np.array([frame.wall_depth]),
        wall_depth_at=np.array([frame.wall_depth_at]), marks=MarkStates(*(array[None] for array in frame.marks)),
        rig=np.array([frame.rig]), stats=frame.stats,
        interventions=() if frame.intervention is None else (frame.intervention,), energy=frame.energy,
        stress=None if frame.stress is None else frame.stress[None],
    )  # fmt: skip
