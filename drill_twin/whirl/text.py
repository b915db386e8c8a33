# SPDX-License-Identifier: Apache-2.0
"""The criterion that decided a motion state, in words, with its numbers."""

from __future__ import annotations

from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.string_shape import Shape


def in_words(state: MotionState, orbit: Orbit, shape: Shape, rules: Criteria, mark: int, row: int, ratio: float) -> str:
    """Why a mark is in `state`; `row` of the orbit 0 for asynchronous motion, 1 for all that moves."""
    whirl, synchronous = float(orbit.radius[0, mark]), float(orbit.synchronous[mark])
    pace = f"radius {100 * float(orbit.radius[row, mark]):.0f} % of the clearance, ratio {ratio:+.2f}"
    match state:
        case MotionState.UNSEEN if orbit.aliased:
            return (
                f"{orbit.sampling:.1f} samples in a revolution, at least {rules.fewest_samples:g} are needed to tell "
                "one whirl from another"
            )
        case MotionState.UNSEEN:
            return "not seen in most of the last revolution"
        case MotionState.AT_REST:
            return f"rotation {abs(orbit.recent_rotation):.3f} rev/s below {rules.rest_rotation} rev/s"
        case MotionState.FIXED_AXIS if not orbit.known:
            return "rotation has begun, less than a revolution seen"
        case MotionState.FIXED_AXIS:
            return f"asynchronous radius {100 * whirl:.1f} %, synchronous {100 * synchronous:.1f} % of the clearance"
        case MotionState.IRREGULAR:
            coherence, unevenness = float(orbit.coherence[row, mark]), float(orbit.unevenness[row, mark])
            return f"{pace}, coherence {coherence:.2f}, unevenness {unevenness:.2f}"
        case MotionState.SPIRAL:
            return f"{pace}, planarity {shape.planarity:.2f} below {rules.planar}"
        case MotionState.SECOND_BENDING:
            return f"{pace}, planarity {shape.planarity:.2f}, marks on both sides, {shape.sides:.2f} of the largest"
        case _:
            sense = "forward" if ratio > 0.0 else "backward"
            touching = float(orbit.contact[mark])
            along = (
                "" if touching <= rules.contact_fraction or state is MotionState.ROLLING else ", sliding along the wall"
            )
            return f"{pace} ({sense}){along}, in contact {100 * touching:.0f} % of the time"
