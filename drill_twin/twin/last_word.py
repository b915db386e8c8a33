# SPDX-License-Identifier: Apache-2.0
"""Why a run was stopped: what was found, which effect is behind it, and what to do."""

import numpy as np

from drill_twin.errors import StoppedError
from drill_twin.guard import REMEDIES, Violation
from drill_twin.rod.types import Array
from drill_twin.solve.blame import Moment, blame
from drill_twin.twin.machine import Machine


def last_word(
    machine: Machine, found: Violation, suspect: Array, target: Array, seconds: float, step: float
) -> StoppedError:
    """The error about a frame that could not be done.

    Args:
        machine: Back at the last good frame.
        found: What was found at last.
        suspect: Node rows u and v in which it was found, shape (2, n + 1, 7).
        target: Weight on bit [N] and rotation [rad/s] that the frame was to reach.
        seconds: Its length [s].
        step: The last time step that was tried [s].
    """
    states = [machine.unknowns, (suspect[0], suspect[1])] if np.isfinite(suspect).all() else [machine.unknowns]
    moments = [
        Moment(u, v, time, step, command)
        for u, v in states
        for time, command in ((machine.time + 0.5 * step, machine.command), (machine.time + seconds, target))
    ]
    kept = machine.block.copy()  # to ask an effect may change what it remembers
    effect, doing = blame(machine.parameters, machine.rod, machine.effects, moments)
    machine.block[:] = kept
    kind = "finite" if "no number" in doing else found.kind
    remedy = REMEDIES["fold in a hole" if kind == "fold" and machine.wall is not None else kind]
    return StoppedError(
        f"the motion could not be followed past t = {machine.time:.6g} s, however often it was "
        f"taken back and the step halved, down to {step:.2g} s: {found.text}, under {target[0]:.6g} N and "
        f"{target[1]:.6g} rad/s{f'; {doing}' if doing else ''}. "
        f"{remedy.capitalize()}",
        machine.time, found.kind, found.node, effect,
    )  # fmt: skip
