# SPDX-License-Identifier: Apache-2.0
"""What the map of the tests is asked for."""

COARSE = {
    "numerics.elements": 8,
    "numerics.step": "10 ms",
    "numerics.frame_rate": "50 Hz",
    "rig.rotation.duration": 1.0,
    "rig.weight_on_bit.duration": 1.0,
}
"""Kernel and resolution of the tests of ensembles."""
ASKED = {
    "wob": "1..40 N", "rpm": "30..180", "duration": 3.0, "steps": 8, "seeds": 2, "growth": False,
    "vary": {"wall_friction.coefficient": "0.1..0.3", "bow.amplitude": "0.01..0.2 mm"},
}  # fmt: skip
