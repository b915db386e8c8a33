# SPDX-License-Identifier: Apache-2.0
"""Parts of the model that are not compared with exact or published numbers, and why; printed on the page."""

_LIST = """
Load of helical buckling in an inclined hole: the published criteria, 2.83 and 3.66 sqrt(EI w sin(alpha) / r), differ
by far more than the error of the twin, and the transition has hysteresis. Snaking and the helix itself are checked.

Roll-up to a full circle: the reference frame of the twist is singular where the string is folded back by half a
turn; 0.9 of that is checked.

Order of convergence through impacts and sticking: the orders are those of smooth motion; in contact there is no exact
path to compare with.

Onset, frequencies and orbits of the paper's own runs: it gives no ramp, bow, damping, drag, friction, wall stiffness
or bit end; pa6_bench uses estimates.

Maps of forward and backward whirl over speed and friction: Jansen 1991 and the lumped models of others are cited,
their numbers are not available to us. Pure rolling, the threshold of internal damping and imbalance are checked.

Start-up of a well off bottom: the first mode and its damping are checked, the break-off torque and the field records
of Aarsnes and Shor 2018 are not.

Regenerative cutting on a real rig: the law's linear limits and its cycle are checked, no record of a bit's depth of cut
is open.

Laboratory rigs: of the published ones only the UFRJ stick-slip rig has raw data, and neither its inertia nor its
stiffness.

Statics and critical speeds of a full bottom-hole assembly: the published table of MADSim is not run yet.

Rods that are curved at rest in space (45 degree bend, twisted ring): a string starts along its hole; its stress-free
curvature is that of a bow.

Rotary inertia and gyroscopic moments of the cross-section: exact checks only (test/dynamics/rotors); without the effect
gyroscopic left out: of the order of (radius / wave length)^2.
"""

NOT_VALIDATED: tuple[tuple[str, str], ...] = tuple(
    (what, " ".join(why.split())) for what, _, why in (part.partition(": ") for part in _LIST.strip().split("\n\n"))
)
"""Part of the model, and reason."""
