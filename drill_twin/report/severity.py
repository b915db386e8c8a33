# SPDX-License-Identifier: Apache-2.0
"""Quantities that a rig's tools print: acceleration of the marks, severity levels, rate of penetration and its energy.

Bounds of the levels 0 to 7 are of this program, not of a vendor: a tool's own are in its manual.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.units.dimension import GRAVITY
from drill_twin.report.quantities import settled_from
from drill_twin.report.recording import Recording

ACCELERATION = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 15.0)
"""Root mean square [g] at which the levels 1 to 7 begin, lateral and axial."""
STICK_SLIP = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
"""Stick-slip index at which the levels 1 to 6 begin; 7 is a bit that turns backwards."""
WORDS = ("none", "low", "low", "medium", "medium", "high", "severe", "severe")
"""Word for each level."""
_EVEN = 0.01
"""Largest difference of two steps of time, over their length, between which an acceleration is taken."""
_BACKWARDS = 0.05
"""Speed of the bit against the rotation, over its mean, from which it turns backwards."""


def severity(bag: Recording) -> dict[str, Any]:
    """Keys of the summary, from `settled_from` on; None for what it does not hold.

    * `acceleration`: by mark `lateral_rms_m_s2`, `lateral_peak_m_s2`, `axial_rms_m_s2`, `axial_peak_m_s2`, and their
      levels `lateral_level` and `axial_level`; of the centre line, without gravity, from positions at the rate
      `acceleration_rate_hz`: a shock shorter than two samples is not in them.
    * `stick_slip_level`: level of the stick-slip index at the end.
    * `rate_of_penetration_m_s`: mean; None where the bit does not drill.
    * `specific_energy_pa`: work of weight and torque of the bit per volume of the hole drilled (Teale 1965).
    """
    rate, found = accelerations(bag)
    return {
        "acceleration_rate_hz": rate,
        "acceleration": found,
        "stick_slip_level": _stick_slip_level(bag),
        **_drilling(bag),
    }


def level(value: float, bounds: tuple[float, ...]) -> int:
    """Level of a value: the number of bounds that it reaches."""
    return bisect_right(bounds, value)


def level_text(at: int) -> str:
    """Level as text, with whose bounds it has."""
    return f"level {at} of 7 ({WORDS[at]}; bounds of this program, not of a vendor)"


def accelerations(bag: Recording) -> tuple[float | None, dict[str, dict[str, float | int]]]:
    """Rate of the samples [Hz] and, by mark, `acceleration` of `severity`; empty without marks or of a sub."""
    time = bag.marks.time
    late = time >= settled_from(bag)
    if late.sum() < 3 or bag.sub or not bag.places:
        return None, {}
    steps = np.diff(time[late])
    step = float(np.median(steps))
    even = np.abs(steps - step) <= _EVEN * step
    chosen = even[1:] & even[:-1]
    lateral = np.diff(bag.centre_lines()[late], 2, axis=0)[chosen] / step**2
    columns = [bag.marks.names.index(place.name) for place in bag.places]
    axial = np.diff(bag.marks.position[late][:, columns, 2], 2, axis=0)[chosen] / step**2
    return 1.0 / step, {
        place.name: {**_sizes("lateral", np.abs(lateral[:, mark])), **_sizes("axial", axial[:, mark])}
        for mark, place in enumerate(bag.places)
        if np.isfinite(lateral[:, mark]).any() and np.isfinite(axial[:, mark]).any()
    }


def _sizes(name: str, values: Array) -> dict[str, float | int]:
    rms = float(np.sqrt(np.nanmean(values**2)))
    peak = float(np.nanmax(np.abs(values)))
    return {f"{name}_rms_m_s2": rms, f"{name}_peak_m_s2": peak, f"{name}_level": level(rms / GRAVITY, ACCELERATION)}


def _stick_slip_level(bag: Recording) -> int | None:
    index, speed = bag.summary.stick_slip_index, bag.rig.bit_speed if len(bag.rig) else np.zeros(0)
    if index is None:
        return None
    late = speed[speed.size // 2 :]
    backwards = late.size and np.nanmin(late * np.sign(np.nanmean(late))) < -_BACKWARDS * abs(np.nanmean(late))
    return len(STICK_SLIP) + 1 if backwards else level(index, STICK_SLIP)


def _drilling(bag: Recording) -> dict[str, float | None]:
    rig = bag.rig
    late = rig.time >= settled_from(bag)
    depth, time = (rig.drilled[late], rig.time[late]) if late.sum() > 1 else (np.zeros(2), np.zeros(2))
    drilled = float(depth[-1] - depth[0])
    if not drilled > 0.0:
        return {"rate_of_penetration_m_s": None, "specific_energy_pa": None}
    power = -rig.bit_torque[late] * rig.bit_speed[late]
    work = float(np.nanmean(power)) * float(time[-1] - time[0]) + float(np.nanmean(rig.bit_force[late])) * drilled
    volume = math.pi * bag.scene.hole.radius_at(bag.scene.length) ** 2 * drilled if bag.scene_known else math.nan
    return {"rate_of_penetration_m_s": drilled / float(time[-1] - time[0]), "specific_energy_pa": work / volume}
