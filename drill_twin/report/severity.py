# SPDX-License-Identifier: Apache-2.0
"""Severity of a recording by what it does to the string (`core.severity`), and rate and energy of drilling."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drill_twin.core.severity import DEFAULT, Bounds, Grade, Severity, grade
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.report.quantities import fatigue, settled_from
from drill_twin.report.recording import Recording
from drill_twin.report.string_forces import fibre_stress
from drill_twin.whirl import BitMotion
from drill_twin.whirl.criteria import FEWEST_SAMPLES
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE
from drill_twin.whirl.severity import accelerations, sizes, torsion_grade, turns_backwards

STEEL = (180e9, 230e9)
"""Young's moduli of steels [Pa], 206.8 GPa within a tenth: the bounds of bending stress are of fatigue of steel."""
POSES_IN_A_CYCLE = 4.0
"""Fewest poses in a cycle of bending, by rotation and whirl, for cycles to be counted; 2 are the limit of Nyquist."""


def severity(bag: Recording) -> dict[str, Any]:
    """Keys of the summary, from `settled_from` on; None for what it does not hold.

    * `severity`: the worst of `severity_by_quantity`: `grade` (0 to 4), `word`, `quantity`, `value` [SI], `place`.
    * `severity_by_quantity`: by field of `core.severity.Bounds` the `value` where it is largest, its `place` and
      `grade`; with `why`, where the bounds do not hold: the grade is then None, or by something else than the value.
    * `severity_source`: source of the bounds that the scene gives; None where none is given.
    * `acceleration`: by mark `lateral_rms_m_s2`, `lateral_peak_m_s2`, `axial_rms_m_s2`, `axial_peak_m_s2`; of the
      centre line, without gravity, from positions at the rate `acceleration_rate_hz`: a shock shorter than two samples
      is not in them. Empty with too few samples in a revolution (`whirl.criteria.FEWEST_SAMPLES`).
    * `contact`: by mark `wall_force_n`, mean force of about an element's length, and `wear_power_w`: mean of force
      times sliding speed across the hole, which wears both; not graded, since no bound of it is known.
    * `bending`: `half_range_pa` of the stress of the fibre with the largest range, its `distance_from_bit_m`, and
      `cycles_per_second`: of the effect `fatigue`, else upward passages of its mean; None with too few poses.
    * `rate_of_penetration_m_s`: mean; None where the bit does not drill.
    * `specific_energy_pa`: work of weight and torque of the bit per volume of the hole drilled (Teale 1965).
    """
    own = bag.scene.severity if bag.scene_known else None
    bounds = DEFAULT if own is None else own.bounds
    rate, found = _accelerations(bag)
    contact, bending = _contact(bag), _bending(bag)
    rows: dict[str, dict[str, Any]] = {}
    for quantity, key, by_mark in (
        *((f"{way}_{size}", f"{way}_{size}_m_s2", found) for way in ("lateral", "axial") for size in ("rms", "peak")),
        ("wall_force", "wall_force_n", contact),
    ):
        known = {mark: row[key] for mark, row in by_mark.items() if math.isfinite(row[key])}
        if known:
            place = max(known, key=lambda mark: known[mark])
            rows[quantity] = {"grade": grade(quantity, known[place], bounds), "value": known[place], "place": place}
    if bending is not None:
        steel = all(STEEL[0] <= tube.youngs_modulus <= STEEL[1] for tube in tubes_of(bag.scene))
        holds = steel or bounds.bending_stress != DEFAULT.bending_stress
        value, at = bending["half_range_pa"], bag.units.text(bending["distance_from_bit_m"], "length")
        rows["bending_stress"] = {
            "grade": grade("bending_stress", value, bounds) if holds else None, "value": value,
            "place": f"{at} from the bit", **({} if holds else {"why": "its bounds are of steel"}),
        }  # fmt: skip
    if torsion := _torsion(bag, bounds):
        rows["stick_slip"] = torsion
    graded = [Severity(row["grade"], name, row["value"], row["place"]) for name, row in rows.items()
              if row["grade"] is not None]  # fmt: skip
    decides = max(graded, default=None, key=lambda one: one.order(bounds))
    why = {} if decides is None else {"why": rows[decides.quantity].get("why", "")}
    return {
        "severity": decides and {**decides.entry, **why},
        "severity_by_quantity": rows,
        "severity_source": own and own.source,
        "acceleration_rate_hz": rate,
        "acceleration": found,
        "contact": contact,
        "bending": bending,
        **_drilling(bag),
    }


def _accelerations(bag: Recording) -> tuple[float | None, dict[str, dict[str, float]]]:
    """Rate of the samples [Hz] and, by mark, `acceleration` of `severity`; empty without marks or of a sub."""
    late = bag.marks.time >= settled_from(bag)
    if late.sum() < 3 or bag.sub or not bag.places or bag.summary.quality.samples_per_revolution < FEWEST_SAMPLES:
        return None, {}
    time, columns = bag.marks.time[late], [bag.marks.names.index(place.name) for place in bag.places]
    step, lateral = accelerations(time, bag.centre_lines()[late])
    _, axial = accelerations(time, bag.marks.position[late][:, columns, 2])
    found = {}
    for mark, place in enumerate(bag.places):
        values = (*sizes(lateral[:, mark]), *sizes(axial[:, mark]))
        names = (f"{way}_{size}_m_s2" for way in ("lateral", "axial") for size in ("rms", "peak"))
        found[place.name] = dict(zip(names, values, strict=True))
    return 1.0 / step, found


def _contact(bag: Recording) -> dict[str, dict[str, float]]:
    """By mark, `contact` of `severity`; empty without forces."""
    late = bag.marks.time >= settled_from(bag)
    if late.sum() < 3 or bag.sub or not bag.places or not np.isfinite(bag.marks.wall_force).any():
        return {}
    centre, found = bag.centre_lines()[late], {}
    speed = np.gradient(centre, bag.marks.time[late], axis=0)
    for mark, place in enumerate(bag.places):
        column = bag.marks.names.index(place.name)
        force = np.hypot(*np.moveaxis(bag.marks.wall_force[late, column, :2], -1, 0))
        around = (speed[:, mark] * np.exp(-1j * np.angle(centre[:, mark]))).imag
        sliding = np.abs(around + place.wall_offset * bag.marks.spin_rate[late, column])
        known = np.isfinite(force * sliding)
        means = [float(values[known].mean()) if known.any() else math.nan for values in (force, force * sliding)]
        found[place.name] = dict(zip(("wall_force_n", "wear_power_w"), means, strict=True))
    return found


def _bending(bag: Recording) -> dict[str, Any] | None:
    """Value of `bending` of `severity`; None without poses of a mesh of the scene."""
    time = bag.poses.time if len(bag.poses) else np.zeros(0)
    chosen = np.flatnonzero(time >= settled_from(bag))
    found = fibre_stress(bag, chosen) if bag.scene_known and chosen.size > 1 else None
    if found is None or not math.isfinite(found[0]):
        return None
    half, place, stress = found
    span, rates = float(np.ptp(time[chosen])), [row["cycles_per_second"] for row in (fatigue(bag) or {}).values()]
    fastest = abs(bag.summary.rotation_rev_s or 0.0) + abs(bag.summary.whirl_frequency_hz or 0.0)
    cycles: float | None = max((rate for rate in rates if rate is not None), default=None)
    if cycles is None and chosen.size / span >= POSES_IN_A_CYCLE * fastest > 0.0:
        cycles = np.count_nonzero((stress[1:] > 0.0) & (stress[:-1] <= 0.0)) / span
    return {"half_range_pa": half, "distance_from_bit_m": place, "cycles_per_second": cycles}


def _torsion(bag: Recording, bounds: Bounds) -> dict[str, Any] | None:
    """Row of the stick-slip index at the end; None where it is not known."""
    index, motion, rig = bag.summary.stick_slip_index, bag.summary.bit, bag.rig
    late = rig.time >= rig.time[-1] - TIME_BASE if len(rig) else np.zeros(0, bool)
    backwards = bool(late.any() and turns_backwards(rig.bit_speed[late], rig.top_drive_speed[late]).any())
    found = torsion_grade(motion, math.nan if index is None else index, bounds, backwards=backwards)
    if found is None:
        return None
    backwards = backwards and found is Grade.SEVERE
    told = motion in {BitMotion.AT_REST, BitMotion.STANDS, BitMotion.DECAYING}
    why = {"why": "the bit turns backwards" if backwards else motion.value} if backwards or told else {}
    none = 0.0 if motion is BitMotion.AT_REST else math.inf
    return {"grade": found, "value": none if index is None else index, "place": "", **why}


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
