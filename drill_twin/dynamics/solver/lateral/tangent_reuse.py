# SPDX-License-Identifier: Apache-2.0
"""Reuse of the factored tangent over iterations and steps (modified Newton method).

Without contact the tangent changes slowly: its factors serve many steps, as in codes for stiff equations (Hairer and
Wanner 1996, IV.8). They are renewed where the step changed or Newton's method slows down.
"""

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel

# Indices into Workspace.reuse: half step of the factors [s] (0: there are none, negative: assembled, not yet factored),
# 1 if they must be renewed, steps for which they are renewed at once, size of the last Newton step, stiffness and
# damping that the effects had added to them [N s/m].
HALF_STEP, RENEW, RENEW_STEPS, LAST_SIZE, ADDED = 0, 1, 2, 3, 4
CONTRACTION = 0.1  # the factors are kept while each Newton step is this much smaller than the last
CHANGE = 0.1  # and while what the effects add to them, mostly the wall, has changed by less than this share
SAME_STEP = 1e-9  # steps of one length differ by rounding
STEPS_AFTER_CHANGE = 8.0  # steps of renewing at once, after factors that were not good enough


@kernel
def outdated(reuse: Array, half_step: float, first_iteration: bool) -> bool:
    """True if the tangent must be assembled and factored again; `first_iteration`: in the first iteration of a step."""
    if first_iteration:
        reuse[LAST_SIZE] = 0.0
        reuse[RENEW_STEPS] = max(reuse[RENEW_STEPS] - 1.0, 0.0)
    if reuse[RENEW_STEPS] > 0.0:
        reuse[RENEW] = 1.0
    other_step: bool = abs(reuse[HALF_STEP] - half_step) > SAME_STEP * half_step
    return other_step or reuse[RENEW] > 0.0


@kernel
def check_contraction(reuse: Array, size: float) -> None:
    """Have the factors renewed if a Newton step of this size is not much smaller than the last."""
    if reuse[LAST_SIZE] > 0.0 and not size < CONTRACTION * reuse[LAST_SIZE]:
        reuse[RENEW] = 1.0
        reuse[RENEW_STEPS] = STEPS_AFTER_CHANGE
    reuse[LAST_SIZE] = size
