# SPDX-License-Identifier: Apache-2.0
"""Error message of a stopped run: violation, effect that caused it, remedy."""

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import StoppedError
from drill_twin.dynamics.audit.diagnose import EvaluationPoint, diagnose
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.violation import REMEDIES, Violation


def failure_report(
    dynamics: Dynamics, found: Violation, suspect: Array, target: Array, seconds: float, step: float
) -> StoppedError:
    """Make the error about a frame that failed in all retries.

    Args:
        dynamics: Dynamics at the last good frame.
        found: Last violation.
        suspect: Node rows u and v with this violation, shape (2, n + 1, 7).
        target: Weight on bit [N] and rotation [rad/s] at the end of the frame.
        seconds: Length of the frame [s].
        step: Last time step [s].
    """
    states = [dynamics.unknowns, (suspect[0], suspect[1])] if np.isfinite(suspect).all() else [dynamics.unknowns]
    moments = [
        EvaluationPoint(u, v, time, step, command)
        for u, v in states
        for time, command in ((dynamics.time + 0.5 * step, dynamics.command), (dynamics.time + seconds, target))
    ]
    kept = dynamics.memory_block.copy()  # evaluation may change the state of an effect
    late = found.kind in {"slow", "long"}
    place = found.node if late else None
    effect, doing = diagnose(dynamics.parameters, dynamics.rod, dynamics.variants, moments, place)
    if found.kind == "long":  # no place and no effect is to blame
        effect, doing = "", ""
    dynamics.memory_block[:] = kept
    kind = "finite" if "no number" in doing else found.kind
    remedy = REMEDIES["fold in a hole" if kind == "fold" and dynamics.wall is not None else kind]
    tried = f", however often it was taken back and the step halved, down to {step:.2g} s"
    return StoppedError(
        f"the motion could not be followed past t = {dynamics.time:.6g} s{'' if late else tried}: {found.text}, under "
        f"{target[0]:.6g} N and "
        f"{target[1]:.6g} rad/s{f'; {doing}' if doing else ''}. "
        f"{remedy.capitalize()}",
        dynamics.time, found.kind, found.node, effect,
    )  # fmt: skip
