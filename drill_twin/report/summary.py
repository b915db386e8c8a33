# SPDX-License-Identifier: Apache-2.0
"""Content of `summary.json`: a run and the findings of its analysis, in plain types."""

from collections.abc import Iterator
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import numpy as np

from drill_twin.core.files.plain_json import plain
from drill_twin.dynamics.twin.frame import COUNTS
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.stamps import seconds
from drill_twin.report.quantities import (
    applied,
    block_weight,
    fatigue,
    loads,
    settled_from,
    soft_wall,
    spectrum_lines,
    wall_depth,
)
from drill_twin.report.recording import Recording
from drill_twin.report.severity import never_stuck, severity
from drill_twin.report.string_forces import left_torque
from drill_twin.report.surface import SLOWEST, surface, without_spikes
from drill_twin.whirl import AnalysisError, BitMotion, MotionPeriod, two_sided_spectrum

_OF_THE_ONSET = ("mark", "confidence", "criterion", "uncertainty_s", "dated", "at_start")
_OF_THE_WHIRL = (
    "mark_onset_s", "whirl_frequency_hz", "whirl_ratio", "whirl_frequency_window_s", "whirl_frequency_interval_hz",
    "whirl_frequency_changes", "frequency_mark", "lasting_motion", "whirl_end_s",
)  # fmt: skip
"""Fields of the onset and of the findings that the summary has under their own names."""
LATE, RESTS, MISSED = 10.0, 0.01, 0.05
"""Time at the end of a run in which the mean speed of the top drive is beside its set-point [s]; range of a set-point
that rests and error of a speed that misses it, over the set-point; chosen, as `estimation.drive_speed`."""
NOTICED = 0.01
"""Least height of its line in the two-sided spectrum, which is half of its amplitude, over the mean speed."""


def summarise(bag: Recording) -> dict[str, Any]:
    """Summary of a recording in plain types: numbers, text, lists, dicts; None for an unknown value, never NaN.

    Returns:
        By key; times in simulated seconds, or in seconds from `start_utc`:

        * `run`, `runs`: number of the run, and of runs in the bag. `start_utc`: date of time 0 where the stamps of the
          bag are dates, else None.
        * `onset_s`, `onset_mark`, `onset_confidence`: the onset of whirl, and how clear it is, a rank from 0 to 1 and
          no probability; None where there was none. `whirl_end_s`:
          time since which the string whirls no more, where the whirl was a transient. `onset_uncertainty_s`,
          `onset_dated`: from a downhole sub, how far off the time may be, and whether it is known within a revolution.
          `onset_at_start`: whether the string whirled already at the start of what is analysed.
        * `lasting_motion`: state of the string for most of the second half of the time since the onset.
        * `whirl_frequency_hz`: mean precession over `whirl_frequency_window_s` [Hz], positive = the sense of rotation,
          at `frequency_mark`; `whirl_ratio`: the same over the rotation meanwhile. None for irregular motion, which has
          no single frequency. `whirl_frequency_changes`: whether it still changes; None for too short a whirl.
          `whirl_frequency_interval_hz`: where it does not change, it lies between in nine of ten cases; else the least
          and the largest mean of a window of three revolutions or more.
        * `spectrum_lines`: highest lines of the spectrum over the same time: `frequency_hz`, `radius_m`.
        * `max_radius_m`: largest distance of the centre line from the hole's axis by mark [m].
        * `motion`, `mark_motion`: timelines of the motion states, each with start and end, and criterion.
        * `whirl_observable`: whether the bag has positions of marks.
        * `bit`, `stick_slip_index`, `largest_stick_slip_index`: motion of the bit at the end, its stick-slip index over
          the last 20 s and the largest; `stick_slip`: stretches of stick-slip; `bit_spectral_peak_hz`: the highest line
          in the spectrum of the bit's speed.
        * `sub`: from a downhole sub, impacts and stick-slip (`drill_twin.whirl.findings.SubFindings`); None for marks.
        * `settled_s`: time from which means are taken, the middle of the recording or the end of the scene's ramps.
          `applied`: `mean`, `min` and `max` from then on of weight on bit [N] and rotation of the top drive [rad/s];
          `load_at`: where the scene has the weight applied, `bit`, `top` or `block`.
        * `loads`: `mean` from `settled_s` on, `min` and `max` in all, of weight on bit, hookload and drag [N] and of
          the torques of top drive and bit [N m] (`drill_twin.report.quantities`); `block`: of the record of a rig,
          the weight of block and top drive in its hookload, and the time of the slips that show it.
        * `severity`, `severity_by_quantity`, `severity_source`, `acceleration`, `acceleration_rate_hz`, `wear_power_w`,
          `bending_cycles_per_second`, `rate_of_penetration_m_s`, `specific_energy_pa`: `drill_twin.report.severity`.
        * `surface`: of a recording without marks, gaps and spikes of the channels of the rig, swing of the torque, and
          the stick-slip index that it means for the string of the scene (`drill_twin.report.surface`).
        * `fatigue`: by section of the effect `fatigue`, stress, cycles, damage and time to a damage of 1
          (`drill_twin.report.quantities`); None without it.
        * `wall`: the largest penetration of the wall, its place and time, after the fall from the axis at the start,
          and that at rest under the largest weight on bit (`drill_twin.report.quantities`).
        * `realtime_factor`: simulated over wall time; `physics_speed`: simulated time over the time spent computing
          the motion. None where not recorded.
        * `steps`, `cut_steps`, `steps_above_tolerance`: time steps taken, how often one was halved, and how many were
          taken while contacts with the wall still alternated between stick and slip; None where not recorded.
        * `guard`: number of frames rejected and repeated with a smaller step, a sentence on each, and the reason if
          the run was stopped.
        * `energy`: the energy balance at the end [J], where the scene asks for it; `residual` as a share of `scale_J`.
        * `units`: the system in which people read it (`field`, `si`, `lab`); the numbers here are in SI.
        * `scene`, `effects`, `elements`, `step_s`, `seed`, `version`, `pace`, `started`: the run.
        * `columns`: of the record of a rig, what is done with each column: `channel` and `unit` it is taken as, or
          `why` it is left out, and values in `left_out` that are no measurement.
        * `duration_s`, `samples`, `quality`, `truncated`, `damage`, `notes`: extent and quality of the bag.
        * `live`: findings recorded while the twin ran, and the number that differ from this analysis.
    """
    found, run, log = bag.summary, bag.log.info, bag.log
    onset, wall, kept = found.onset, wall_depth(bag), without_spikes(bag)
    block = block_weight(bag, kept)
    summary = {
        "run": bag.run,
        "runs": bag.runs,
        "start_utc": start_utc(bag.bag),
        "scene": bag.scene.name if bag.scene_known else None,
        "units": bag.units.name,
        "whirl_observable": found.observable,
        "onset_s": found.onset_s,
        **{f"onset_{key}": getattr(onset, key, None) for key in _OF_THE_ONSET},
        **{key: getattr(found, key) for key in _OF_THE_WHIRL},
        "spectrum_lines": spectrum_lines(bag),
        "rotation_rev_s": found.rotation_rev_s,
        "max_radius_m": found.max_radius_m,
        "clearance_m": {mark.name: mark.clearance for mark in bag.places},
        "motion": timeline(found.motion, bag.duration),
        "mark_motion": {mark: timeline(periods, bag.duration) for mark, periods in found.mark_motion.items()},
        "bit": BitMotion.VIBRATION if never_stuck(bag) else found.bit,
        **{key: getattr(found, key) for key in ("stick_slip_index", "largest_stick_slip_index")},
        "stick_slip": [{**asdict(period), "frequency_hz": period.frequency_hz} for period in found.stick_slip],
        "bit_spectral_peak_hz": bit_peak(bag),
        "sub": None if found.sub is None else asdict(found.sub),
        "settled_s": settled_from(bag),
        "applied": applied(bag, kept),
        "load_at": bag.scene.rig.weight_on_bit.at if bag.scene_known else None,
        "loads": loads(bag, kept, block["weight_n"] if block else 0.0),
        "block": block,
        **severity(bag),
        "surface": surface(bag, kept),
        "fatigue": fatigue(bag),
        "wall": wall,
        **log.speeds,
        **{key: log.steps.get(key) for key in COUNTS},
        "guard": log.guard.summary(),
        "energy": log.guard.energy or None,
        "elements": run.get("elements", bag.nodes - 1 if bag.nodes else None),
        "step_s": run.get("step_s"),
        "effects": list(run.get("effects", bag.scene.effect_names if bag.scene_known else ())),
        "seed": run.get("seed", bag.scene.numerics.seed if bag.scene_known else None),
        **{key: run.get(key) for key in ("version", "pace", "started")},
        "duration_s": bag.duration,
        "samples": found.quality.accepted,
        "quality": found.quality._asdict(),
        "truncated": bag.bag.truncated,
        "damage": bag.bag.damage,
        "columns": getattr(bag.bag, "columns", []),
        "notes": [*getattr(bag.bag, "notes", ()), *found.notes, *_notes(bag), *soft_wall(wall, bag.units)],
        "live": {
            "onset_s": bag.live.onset.time - seconds(bag.bag.origin) if bag.live.onset else None,
            "messages": bag.live.messages,
            "differing": bag.live.differing,
        },
    }
    return dict(plain(summary))


def start_utc(bag: Bag) -> str | None:
    """Date of time 0; None where the stamps of a bag are no dates."""
    if not bag.origin:
        return None
    return datetime.fromtimestamp(seconds(bag.origin), UTC).isoformat(" ", "milliseconds").removesuffix("+00:00")


def timeline(periods: tuple[MotionPeriod, ...], end: float) -> list[dict[str, Any]]:
    """Motion states in order, each with start and end [s], state and criterion."""
    ends = [*(period.start_s for period in periods[1:]), end]
    lines: list[dict[str, Any]] = []
    for period, until in zip(periods, ends, strict=False):
        if lines and lines[-1]["state"] is period.state:
            lines[-1]["end_s"] = until
        elif until > period.start_s:
            state, criterion = period.state, period.criterion
            lines.append({"start_s": period.start_s, "end_s": until, "state": state, "criterion": criterion})
    return lines


def bit_peak(bag: Recording) -> float | None:
    """Frequency of the highest line in the spectrum of the bit's speed above 0.1 Hz [Hz]; None where there is none."""
    if not len(bag.rig):
        return None
    speed = bag.rig.bit_speed
    try:
        peak = two_sided_spectrum(bag.rig.time, speed.astype(complex)).peak(SLOWEST, np.inf)
    except AnalysisError:
        return None
    return None if peak is None or peak.radius < NOTICED * abs(float(np.nanmean(speed))) else peak.frequency


def _missed_speed(bag: Recording) -> Iterator[str]:
    """Sentence on a top drive that does not turn at its set-point at the end, though the set-point rests."""
    if not (len(bag.commands) and len(bag.rig)):
        return
    late = bag.rig.time >= bag.rig.time[-1] - LATE
    wanted = np.interp(bag.rig.time[late], bag.commands.time, bag.commands.rotation)
    aim, speed = float(wanted.mean()), float(bag.rig.top_drive_speed[late].mean())
    if np.ptp(wanted) <= RESTS * abs(aim) and abs(speed - aim) > MISSED * abs(aim):
        more = "" if abs(speed) > abs(aim) else ", a higher `rig.top_drive.torque_limit`"
        yield (
            f"the top drive missed its set-point of {bag.units.text(aim, 'rotation')}: it turned at "
            f"{bag.units.text(speed, 'rotation')} on average over the last {min(LATE, bag.duration):g} s; a longer "
            f"run{more} or other gains may reach it"
        )


def _notes(bag: Recording) -> list[str]:
    guard = bag.log.guard
    notes = list(bag.log.left_out)
    if guard.stopped:
        notes.append(f"the run was stopped: {guard.stopped}")
    elif guard.count:
        notes.append(f"the guard had {guard.count} frames done again with a smaller step; see `guard`")
    if bag.sub:
        notes.append(
            f"positions belong to the section of the sub {bag.sub}, about its mean, from its readings: "
            "contact is not known, and a radius is over the clearance where that mean has moved"
        )
    elif bag.rotation_from_spin and bag.places:
        notes.append("the bag holds no rig states: the rotation is taken from the spin of the marks")
    notes += [*_missed_speed(bag), *(left_torque(bag) if bag.scene_known else ()), *bag.skipped.sentences()]
    if bag.unpaired:
        notes.append(f"{bag.unpaired} states of the marks or the rig have no partner with the same stamp")
    if bag.live.differing:
        notes.append(
            f"{bag.live.differing} of {bag.live.messages} findings recorded live differ from this analysis: "
            f"the live analyzer {'read marks, ' if bag.sub else ''}missed samples, or was another version"
        )
    return notes
