# SPDX-License-Identifier: Apache-2.0
"""Summary of a run from what the analysis holds, with the limits of its findings as sentences."""

import math
from collections.abc import Sequence
from dataclasses import replace

from drill_twin.core.arrays import number_or_none
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.decisions import Decisions, doubt
from drill_twin.whirl.findings import Quality, Summary
from drill_twin.whirl.frequency import whirl_frequency
from drill_twin.whirl.motion.states import lasting_motion, whirl_end
from drill_twin.whirl.motion.stick_slip import StickSlip


def summarise(state: Columns, names: Sequence[str], decisions: Decisions, bit: StickSlip, quality: Quality) -> Summary:
    """The findings of the run so far.

    Args:
        state: State of the analysis.
        names: Of the marks.
        decisions: Onset and motion states.
        bit: Motion of the bit.
        quality: Counts of samples.
    """
    statistics, largest, timelines = state.statistics, state.samples.largest.tolist(), decisions.timelines
    motion, onset = timelines[-1].periods, decisions.onset
    seconds, turns = statistics.seconds.item(), statistics.turns.item()
    end = decisions.origin + float(state.full.time[0])
    lasting, over = lasting_motion(motion, decisions.origin if onset is None else onset.time_s, end), whirl_end(motion)
    irregular = lasting is MotionState.IRREGULAR
    whirl = onset and whirl_frequency(
        statistics, names, timelines, onset.time_s, over or end, decisions.origin, irregular=irregular
    )
    unseen = [name for name, radius in zip(names, largest, strict=True) if not math.isfinite(radius)]
    return replace(
        whirl or Summary(),
        onset=onset,
        mark_onset_s=dict(zip(names, decisions.crossed, strict=True)),
        max_radius_m=dict(zip(names, map(number_or_none, largest), strict=True)),
        rotation_rev_s=turns / seconds if seconds > 0.0 else None,
        motion=motion,
        mark_motion={name: timeline.periods for name, timeline in zip(names, timelines[:-1], strict=True)},
        stick_slip=tuple(bit.periods),
        bit=bit.motion,
        stick_slip_index=number_or_none(bit.index),
        largest_stick_slip_index=number_or_none(bit.largest_index),
        quality=quality,
        lasting_motion=lasting,
        whirl_end_s=over,
        notes=_notes(
            quality, timelines[-1].dropped, decisions.rolling_ratio, unseen, unknown=onset is not None and whirl is None
        ),
    )


def _notes(
    quality: Quality, dropped: int, rolling_ratio: float, unseen: list[str], *, unknown: bool
) -> tuple[str, ...]:
    """Limits of the findings, as sentences."""
    notes = []
    rate, fewest = quality.samples_per_revolution, criteria.FEWEST_SAMPLES
    if quality.accepted == 0:
        notes.append("no sample could be analysed")
    elif math.isnan(rate):
        notes.append("the string did not rotate: whirl is not defined")
    elif rate < fewest:
        notes.append(
            f"{rate:.1f} samples in a revolution: too few for the rotation, at least {fewest:g} are needed; the "
            "pace and the kind of a whirl would be another's (aliasing) and are not reported"
        )
    elif why := doubt(rate, rolling_ratio):
        notes.append(why)
    counts = {
        "duplicate samples": quality.duplicate,
        "samples from before one already seen (time running backwards)": quality.late,
        "incomplete samples": quality.incomplete,
        "single marks missing from samples": quality.missing_marks,
    }
    notes += [f"{count} {what} skipped" for what, count in counts.items() if count]
    if quality.gaps:
        notes.append(f"{quality.gaps} gaps of more than 3/4 of a revolution")
    if unseen and quality.accepted:
        notes.append(f"never seen: {', '.join(unseen)}")
    if unknown and rate >= fewest:
        notes.append(
            "no whirl frequency: the whirl lasts for too few revolutions, or has two lines of nearly equal size"
        )
    if dropped:
        notes.append(f"{dropped} later changes of the string's motion are not listed")
    return tuple(notes)
