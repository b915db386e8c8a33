# SPDX-License-Identifier: Apache-2.0
"""Severity of a recording by what it does to the string (`core.severity`), rate and energy of drilling; problems."""

import math
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.severity import DEFAULT, Bounds, Grade, grade, told, worst_row
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.report.load_text import Summary, units_of
from drill_twin.report.quantities import fatigue, settled_from
from drill_twin.report.recording import Recording
from drill_twin.report.string_forces import fibre_stress, force_on_joint
from drill_twin.whirl import BitMotion, MotionState
from drill_twin.whirl.criteria import FEWEST_SAMPLES
from drill_twin.whirl.motion.stick_slip_index import FULL, TIME_BASE
from drill_twin.whirl.severity import accelerations, sizes, torsion_grade, turns_backwards

STAYS = "its change alone: the string did not turn, and bending that stays, as in a curved hole, is not in it"
"""Note on the bending stress of fibres that do not go round the bend."""
STEEL = (150e9, 230e9)
"""Young's moduli of steel [Pa], 207 GPa, or less where a scene has one modulus of pipe and joints; of titanium 115."""
_OF_MARKS = ("lateral_rms", "lateral_peak", "axial_rms", "axial_peak")
POSES_IN_A_CYCLE = 4.0
"""Fewest poses in a cycle of bending, by rotation and whirl, for cycles to be counted; 2 are the limit of Nyquist."""


def severity(bag: Recording) -> dict[str, Any]:
    """Keys of the summary, from `settled_from` on; None for what it does not hold.

    * `severity`: the worst of `severity_by_quantity`: `grade` (0 to 4), `word`, `quantity`, `value` [SI], `place`,
      `why`, empty where the value alone decides, and `unknown`, empty unless lateral acceleration is not known.
    * `severity_by_quantity`: by field of `core.severity.Bounds` the `value` where it is largest, its `place` (mark, or
      section, with its `distance_from_bit_m`) and `grade`; `why` is not empty where the grade is None, since bounds of
      this program do not hold there (wall force on collars, stress of another material than steel), or where something
      else than the value decides. An acceleration that is not known has neither value nor grade, and says why.
    * `severity_source`: source of the bounds that the scene gives, and of which; None where none is given.
    * `acceleration`: by mark `lateral_rms_m_s2`, `lateral_peak_m_s2`, `axial_rms_m_s2`, `axial_peak_m_s2`; of the
      centre line, without gravity, from positions at the rate `acceleration_rate_hz`: a shock shorter than two samples
      is not in them. Without marks above `numerics.lateral_from`, which stay on the axis. Empty with too few samples in
      a revolution (`whirl.criteria.FEWEST_SAMPLES`).
    * `wear_power_w`: by mark the mean of wall force, on about an element's length, times sliding speed across the
      hole, which wears both surfaces; not graded, since no bound of it is known.
    * `bending_cycles_per_second`: of the effect `fatigue`, else upward passages of the mean stress of the fibre with
      the largest range; None with too few poses.
    * `rate_of_penetration_m_s`: mean; None where the bit does not drill, or not for a whole turn.
    * `specific_energy_pa`: work of weight and torque of the bit per volume of the hole drilled (Teale 1965).
    """
    own = bag.scene.severity if bag.scene_known else None
    bounds = DEFAULT if own is None else own.bounds
    rate, found, wear = _of_marks(bag)
    values = [(key.removesuffix("_m_s2"), size, mark) for mark, row in found.items() for key, size in row.items()]
    time = bag.poses.time if bag.scene_known and len(bag.poses) else np.zeros(0)
    late, cycles = np.flatnonzero(time >= settled_from(bag)), None
    distance: dict[str, float] = {}
    if (fibre := fibre_stress(bag, late)) is not None:
        for quantity, (value, place) in (("wall_force", force_on_joint(bag, late)), ("bending_stress", fibre[:2])):
            values.append((quantity, value, bag.scene.string.section_at(place).name))
            distance[quantity] = place
        cycles = _cycles(bag, time[late], fibre[2])
    rows: dict[str, dict[str, Any]] = {}
    for quantity, value, mark in sorted((one for one in values if math.isfinite(one[1])), key=itemgetter(1)):
        why = _not_graded(bag, quantity) if getattr(bounds, quantity) == getattr(DEFAULT, quantity) else ""
        known = None if why else grade(quantity, value, bounds)
        rows[quantity] = {"grade": known, "value": value, "place": mark, "why": why}  # the largest is the last
        rows[quantity]["distance_from_bit_m"] = distance.get(quantity)
    if fibre is not None and np.ptp(bag.poses.spin[late], axis=0).min() < math.pi:
        rows["bending_stress"]["why"] = rows["bending_stress"]["why"] or STAYS
    unseen = _unseen(bag) or "no three samples at even steps of time"
    missing = {"grade": None, "value": None, "place": "", "why": unseen, "distance_from_bit_m": None}
    rows |= {name: missing for name in _OF_MARKS if name not in rows}
    if torsion := _torsion(bag, bounds):
        rows["stick_slip"] = torsion
    return {
        "severity": worst_row(rows, bounds),
        "severity_by_quantity": rows,
        "severity_source": own and own.whose,
        "acceleration_rate_hz": rate,
        "acceleration": found,
        "wear_power_w": wear,
        "bending_cycles_per_second": cycles,
        **_drilling(bag),
    }


def _of_marks(bag: Recording) -> tuple[float | None, dict[str, dict[str, float]], dict[str, float]]:
    """Rate of the samples [Hz] and, by mark, `acceleration` and `wear_power_w`; empty without marks or of a sub."""
    late = bag.marks.time >= settled_from(bag)
    if late.sum() < 3 or _unseen(bag):
        return None, {}, {}
    time, columns = bag.marks.time[late], [bag.marks.names.index(place.name) for place in bag.places]
    centre, push = bag.centre_lines()[late], bag.marks.wall_force[late][:, columns, :2]
    step, lateral = accelerations(time, centre)
    _, axial = accelerations(time, bag.marks.position[late][:, columns, 2])
    around = (np.gradient(centre, time, axis=0) * np.exp(-1j * np.angle(centre))).imag
    rim = np.array([place.wall_offset for place in bag.places]) * bag.marks.spin_rate[late][:, columns]
    power, found = (np.linalg.norm(push, axis=-1) * np.abs(around + rim)).mean(axis=0), {}
    names = [f"{name}_m_s2" for name in _OF_MARKS]
    joint = (joint_of(bag.scene) if bag.scene_known else None) or math.inf
    moving = [(mark, place.name) for mark, place in enumerate(bag.places) if place.distance_from_bit <= joint]
    for mark, name in moving:
        found[name] = dict(zip(names, (*sizes(lateral[:, mark]), *sizes(axial[:, mark])), strict=True))
    return 1.0 / step, found, {name: float(power[mark]) for mark, name in moving}


def _unseen(bag: Recording) -> str:
    """Reason for which no acceleration of a mark can be told from its positions; empty where it can."""
    rate = bag.summary.quality.samples_per_revolution
    if bag.sub or not bag.places:
        return "positions of marks are needed"
    return f"{rate:.1f} samples in a revolution, {FEWEST_SAMPLES:g} are needed" if rate < FEWEST_SAMPLES else ""


def _not_graded(bag: Recording, quantity: str) -> str:
    """Reason for which the bounds of this program do not hold for a quantity; empty where they do."""
    if quantity == "wall_force":
        return "its bounds are of tool joints in casing"
    steel = quantity != "bending_stress" or all(STEEL[0] <= t.youngs_modulus <= STEEL[1] for t in tubes_of(bag.scene))
    return "" if steel else "its bounds are of steel"


def _cycles(bag: Recording, time: Array, stress: Array) -> float | None:
    """`bending_cycles_per_second` of `severity`, from the stress of a fibre about its mean."""
    rates = [row["cycles_per_second"] or 0.0 for row in (fatigue(bag) or {}).values()]
    fastest = abs(bag.summary.rotation_rev_s or 0.0) + abs(bag.summary.whirl_frequency_hz or 0.0)
    if rates or not time.size > POSES_IN_A_CYCLE * fastest * np.ptp(time) > 0.0:
        return max(rates, default=None)
    return float(np.count_nonzero((stress[1:] > 0.0) & (stress[:-1] <= 0.0)) / np.ptp(time))


def _torsion(bag: Recording, bounds: Bounds) -> dict[str, Any] | None:
    """Row of the stick-slip index at the end; None where it is not known."""
    index, motion, rig = bag.summary.stick_slip_index, bag.summary.bit, bag.rig
    late = rig.time >= rig.time[-1] - TIME_BASE if len(rig) else np.zeros(0, bool)
    backwards = bool(late.any() and turns_backwards(rig.bit_speed[late], rig.top_drive_speed[late]).any())
    found = torsion_grade(motion, math.nan if index is None else index, bounds, backwards=backwards)
    if found is None:
        return None
    why = motion.value if motion in {BitMotion.AT_REST, BitMotion.STANDS, BitMotion.DECAYING} else ""
    why = "the bit turns backwards" if backwards and found is Grade.SEVERE else why
    if never_stuck(bag) and not backwards:
        below = grade("stick_slip", math.nextafter(FULL, 0.0), bounds)
        found, why = min(found, found if below is None else below), "an upper estimate: the bit never stuck"
    none = 0.0 if motion is BitMotion.AT_REST else math.inf
    return {
        "grade": found,
        "value": none if index is None else index,
        "place": "",
        "why": why,
        "distance_from_bit_m": None,
    }


def never_stuck(bag: Recording) -> bool:
    """Tell whether the index of a record is of stick-slip, but its bit slows and never stands (`report.surface`)."""
    return not bag.places and bag.summary.bit is BitMotion.STICK_SLIP and not bag.summary.stick_slip


def _drilling(bag: Recording) -> dict[str, float | None]:
    rig = bag.rig
    late = rig.time >= settled_from(bag)
    depth, time = (rig.drilled[late], rig.time[late]) if late.sum() > 1 else (np.zeros(2), np.zeros(2))
    drilled, lasted = float(depth[-1] - depth[0]), float(time[-1] - time[0])
    if not drilled > 0.0 or abs(float(np.nanmean(rig.bit_speed[late]))) * lasted < math.tau:  # at rest it only sinks in
        return {"rate_of_penetration_m_s": None, "specific_energy_pa": None}
    power = -rig.bit_torque[late] * rig.bit_speed[late]
    work = float(np.nanmean(power)) * lasted + float(np.nanmean(rig.bit_force[late])) * drilled
    volume = math.pi * bag.scene.hole.radius_at(bag.scene.length) ** 2 * drilled if bag.scene_known else math.nan
    return {"rate_of_penetration_m_s": drilled / lasted, "specific_energy_pa": work / volume}


WHIRL, AXIAL, TORSION = "lateral motion", "axial motion", "torsion"
PROBLEMS = {
    WHIRL: ("lateral_rms", "lateral_peak", "bending_stress"),
    AXIAL: ("axial_rms", "axial_peak"),
    TORSION: ("stick_slip",),
}
"""Quantities of severity of each problem; the share that a repeat leaves is of the first one. The mean force of the
wall is of none: a string that lies still on the low side has it too."""


class Motion(NamedTuple):
    """Motion of a run, and how severe it is."""

    summary: Summary
    bounds: Bounds

    @property
    def whirls(self) -> bool:
        """True with an onset of whirl."""
        return self.summary["onset_s"] is not None

    @property
    def swings(self) -> bool:
        """True for a swing in a plane, which is no whirl."""
        return bool(self.summary["lasting_motion"] == MotionState.PLANE_SWING.value)

    @property
    def decays(self) -> bool:
        """True for a free swing of the bit that dies away."""
        return bool(self.summary["bit"] == BitMotion.DECAYING.value)

    def worst(self, problem: str) -> dict[str, Any] | None:
        """Entry of the quantity that decides (`core.severity.worst_row`); None where none is known."""
        rows = {key: row for key in PROBLEMS[problem] if (row := self.summary["severity_by_quantity"].get(key))}
        return worst_row(rows, self.bounds)

    def grade(self, problem: str) -> Grade:
        """Grade of a problem; none where it is not known."""
        top = self.worst(problem)
        return Grade(top["grade"]) if top else Grade.NONE

    def has(self, problem: str) -> bool:
        """True where the run has the problem: it whirls or swings, or its grade is medium or more."""
        kind = {WHIRL: self.whirls or self.swings, TORSION: self.decays}.get(problem, False)
        return kind or self.grade(problem) >= Grade.MEDIUM

    def size(self, problem: str) -> float:
        """Value of the first quantity of a problem [SI]; NaN where it is not known."""
        value = self.summary["severity_by_quantity"].get(PROBLEMS[problem][0], {}).get("value")
        return math.nan if value is None else float(value)

    def text(self, problem: str) -> str:
        """Grade and the quantity that decides it, such as `medium: lateral acceleration 2.6 g rms at mark_2`."""
        return told(self.worst(problem), units_of(self.summary))


LEFT = 0.5
"""Share of the run's deciding quantity above which a repeat still moves as the run does; chosen, not measured. What
unbalance forces is proportional to the unbalance: of a cause almost nothing is left."""
BACKWARD = tuple(
    one.value for one in (MotionState.BACKWARD_WHIRL, MotionState.ROLLING, MotionState.CREEPING, MotionState.IMPACTS)
)
FORWARD = (MotionState.FORWARD_WHIRL.value, MotionState.SYNCHRONOUS_WHIRL.value)


def cured(problem: str, run: Motion, found: Motion, growth: float | None, *, less: bool) -> bool:
    """True where a repeat does not have a problem of a run.

    Args:
        problem: Of `PROBLEMS`.
        run: Motion of the run.
        found: Motion of the repeat.
        growth: Of the repeat's fastest lateral mode [1/s]; None where it is not known.
        less: A set-point is lowered: then the grade alone decides, where it has fallen.
    """
    falls = run.grade(problem) > Grade.LOW >= found.grade(problem)
    half = not found.size(problem) > LEFT * run.size(problem)  # NaN: not known
    if problem != WHIRL:
        return falls and found.worst(problem) is not None and (less or half)
    if not found.whirls:
        return half and not (growth is not None and growth > 0.0)
    if found.summary["whirl_end_s"] is not None and run.summary["whirl_end_s"] is None:
        return True
    was, is_now = run.summary["lasting_motion"], found.summary["lasting_motion"]
    return (falls and (less or (half and was != is_now))) or (half and was in BACKWARD and is_now in FORWARD)
