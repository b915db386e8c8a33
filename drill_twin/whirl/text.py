# SPDX-License-Identifier: Apache-2.0
"""Text of the criterion that decided a motion state, with its numbers."""

from __future__ import annotations

from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.orbit.carrier import Carrier
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.string_shape import StringShape

FEW_DIGITS = 0.1
"""Ratio from which two decimals are enough."""


def doubt(criteria: Criteria, samples: float, rolling_ratio: float) -> str:
    """Reason why findings from so many samples in a revolution are not definite; empty where they are."""
    if samples >= criteria.needed_in_orbit * max(criteria.definite_ratio, abs(rolling_ratio)):
        return ""
    rolls = abs(rolling_ratio) * criteria.needed_in_orbit > samples
    what = f"rolling, at {rolling_ratio:+.1f} times the rotation," if rolls else "a faster whirl"
    return (
        f"not definite: {samples:.1f} samples in a revolution show up to {samples / criteria.needed_in_orbit:.1f} "
        f"times the rotation, and {what} would look like another motion"
    )


def criterion_text(
    state: MotionState,
    orbit: Orbit,
    shape: StringShape,
    criteria: Criteria,
    mark: int,
    row: int,
    ratio: float,
    *,
    carrier: Carrier,
    contact_known: bool = True,
) -> str:
    """Describe the criterion of a mark's `state`.

    Args:
        state: The state to explain.
        orbit: Orbits of the marks.
        shape: Shape of the string.
        criteria: Thresholds.
        mark: Index of the mark.
        row: Row of the orbit: 0 for the asynchronous part, 1 for the motion about the offset.
        ratio: Precession over rotation.
        carrier: Carriers of the orbits.
        contact_known: Whether the distance from the axis of the hole is known; a downhole sub knows it about its mean.
    """
    whirl, synchronous = float(orbit.radius[0, mark]), float(orbit.synchronous[mark])
    sense = "forward" if ratio > 0.0 else "backward"
    digits = 2 if abs(ratio) >= FEW_DIGITS else 3
    orbit_text = f"radius {100 * float(orbit.radius[row, mark]):.0f} % of the clearance, ratio {ratio:+.{digits}f}"
    match state:
        case MotionState.NOT_OBSERVABLE if orbit.samples_per_revolution < criteria.fewest_samples:
            return (
                f"{orbit.samples_per_revolution:.1f} samples in a revolution, at least {criteria.fewest_samples:g} are "
                "needed to tell one whirl from another"
            )
        case MotionState.NOT_OBSERVABLE if carrier.hidden[mark]:
            return (
                f"fewer than {criteria.fewest_in_orbit:g} samples in an orbit: the samples show neither its sense nor "
                "its pace"
            )
        case MotionState.NOT_OBSERVABLE:
            return "not seen in most of the last revolution"
        case MotionState.AT_REST:
            return f"rotation {abs(orbit.recent_rotation):.3f} rev/s below {criteria.rest_rotation} rev/s"
        case MotionState.FIXED_AXIS if not orbit.known:
            return "rotation has begun, less than a revolution seen"
        case MotionState.FIXED_AXIS if row == 0 and abs(ratio) < criteria.standing_ratio:
            return f"{orbit_text}: displaced, and stands there (slower than {criteria.standing_ratio:.3f})"
        case MotionState.FIXED_AXIS:
            return f"asynchronous radius {100 * whirl:.1f} %, synchronous {100 * synchronous:.1f} % of the clearance"
        case MotionState.IRREGULAR:
            coherence, unevenness = float(orbit.coherence[row, mark]), float(orbit.unevenness[row, mark])
            return f"{orbit_text}, coherence {coherence:.2f}, unevenness {unevenness:.2f}"
        case MotionState.SPIRAL:
            return f"{orbit_text} ({sense}), a helix: planarity {shape.planarity:.2f} below {criteria.planar}"
        case MotionState.SECOND_BENDING:
            return (
                f"{orbit_text} ({sense}), planarity {shape.planarity:.2f}, marks on both sides, "
                f"{shape.second_lobe:.2f} of the largest"
            )
        case _ if not contact_known:
            return f"{orbit_text} ({sense}), about its mean"
        case _:
            contact = float(orbit.contact[mark])
            slides = contact > criteria.contact_fraction and state is not MotionState.ROLLING
            sliding = ", sliding along the wall" if slides else ""
            return f"{orbit_text} ({sense}){sliding}, in contact {100 * contact:.0f} % of the time"
