# SPDX-License-Identifier: Apache-2.0
"""Decisions of the analysis that need fits and texts: crossings, the onset, changes of the motion state.

The text of a motion state gives the criterion that decided it, with its numbers.
"""

from collections.abc import Callable

import numpy as np

from drill_twin.whirl import criteria
from drill_twin.whirl.analysis_loop import CHECK, CROSSED, DECIDE, DESCRIBE
from drill_twin.whirl.columns import Columns
from drill_twin.whirl.criteria import MotionState
from drill_twin.whirl.findings import Onset
from drill_twin.whirl.history import newest, newest_in
from drill_twin.whirl.motion.states import CHANGED, KEPT, NO_WHIRL, STATES, Timeline
from drill_twin.whirl.onset.synchronous_onset import synchronous_begins
from drill_twin.whirl.onset.threshold_crossing import Crossing
from drill_twin.whirl.onset_detector import OnsetDetector
from drill_twin.whirl.orbit.runout_separation import correct, fit_anew

FEW_DIGITS = 0.1
"""Ratio from which two decimals are enough; chosen, not measured."""


def doubt(samples: float, rolling_ratio: float) -> str:
    """Reason why findings from so many samples in a revolution are not definite; empty where they are."""
    if samples >= criteria.NEEDED_IN_ORBIT * max(criteria.DEFINITE_RATIO, abs(rolling_ratio)):
        return ""
    rolls = abs(rolling_ratio) * criteria.NEEDED_IN_ORBIT > samples
    what = f"rolling, at {rolling_ratio:+.1f} times the rotation," if rolls else "a faster whirl"
    return (
        f"not definite: {samples:.1f} samples in a revolution show up to {samples / criteria.NEEDED_IN_ORBIT:.1f} "
        f"times the rotation, and {what} would look like another motion"
    )


def criterion_text(found: MotionState, state: Columns, mark: int, *, contact_known: bool = True) -> str:
    """Describe the criterion of a mark's motion.

    Args:
        found: The motion state to explain.
        state: State of the analysis.
        mark: Index of the mark.
        contact_known: Whether the distance from the axis of the hole is known; a downhole sub knows it from its mean.
    """
    orbit, shape, row = state.orbit, state.shape, 0 if state.onsets.active[mark] else 1
    ratio = float(orbit.ratio[mark])
    whirl, synchronous = float(orbit.radius[0, mark]), float(orbit.synchronous[mark])
    sense = "forward" if ratio > 0.0 else "backward"
    digits = 2 if abs(ratio) >= FEW_DIGITS else 3
    radius = float(orbit.radius[row, mark])
    beyond, mean = (" (about its mean place)" if size > 1.0 else "" for size in (radius, max(whirl, synchronous)))
    orbit_text = f"radius {100 * radius:.0f} % of the clearance{beyond}, ratio {ratio:+.{digits}f}"
    match found:
        case MotionState.NOT_OBSERVABLE if orbit.samples_per_revolution[0] < criteria.FEWEST_SAMPLES:
            return (
                f"{orbit.samples_per_revolution[0]:.1f} samples in a revolution, at least "
                f"{criteria.FEWEST_SAMPLES:g} are needed to tell one whirl from another"
            )
        case MotionState.NOT_OBSERVABLE if state.carrier.hidden[mark]:
            return (
                f"fewer than {criteria.FEWEST_IN_ORBIT:g} samples in an orbit: the samples show neither its sense nor "
                "its pace"
            )
        case MotionState.NOT_OBSERVABLE:
            return "not seen in most of the last revolution"
        case MotionState.AT_REST:
            return f"rotation {abs(orbit.recent_rotation[0]):.3f} rev/s below {criteria.REST_ROTATION} rev/s"
        case MotionState.FIXED_AXIS if not orbit.known[0]:
            return "rotation has begun, less than a revolution seen"
        case MotionState.FIXED_AXIS if row == 0 and abs(ratio) < criteria.STANDING_RATIO:
            return f"{orbit_text}: displaced, and stands there (slower than {criteria.STANDING_RATIO:.3f})"
        case MotionState.PLANE_SWING:
            return (
                f"to and fro, rms radius {100 * state.onsets.swing[mark]:.1f} % of the clearance: its lines of either "
                f"sense are nearly equal (rotary coefficient below {criteria.ROTARY:g})"
            )
        case MotionState.FIXED_AXIS:
            sizes = f"asynchronous radius {100 * whirl:.1f} %, synchronous {100 * synchronous:.1f} %"
            return f"{sizes} of the clearance{mean}"
        case MotionState.IRREGULAR:
            coherence, unevenness = float(orbit.coherence[row, mark]), float(orbit.unevenness[row, mark])
            left = 100 * float(orbit.left[mark])
            rough = float(state.motion.irregularity.share[mark])
            return (
                f"{orbit_text}, rough for {100 * rough:.0f} % of the last {criteria.IRREGULARITY_MEMORY:g} revolutions "
                f"(coherence below {criteria.COHERENCE:g} or unevenness above {criteria.UNEVENNESS:g}); now coherence "
                f"{coherence:.2f}, unevenness {unevenness:.2f}, {left:.0f} % of the power in neither of its two lines"
            )
        case MotionState.SPIRAL:
            return (
                f"{orbit_text} ({sense}), a helix: planarity, now {shape.planarity[0]:.2f}, was below {criteria.PLANAR}"
            )
        case MotionState.SECOND_BENDING:
            return (
                f"{orbit_text} ({sense}), planarity {shape.planarity[0]:.2f}, marks on both sides, "
                f"{shape.second_lobe[0]:.2f} of the largest"
            )
        case _ if not contact_known:
            return f"{orbit_text} ({sense}), about its mean"
        case _:
            contact = float(orbit.contact[mark])
            rolling_ratio, how = float(state.marks.rolling_ratio[mark]), ""
            if found is MotionState.IMPACTS:
                how = f", {orbit.strikes[mark]:.1f} strikes in a revolution"
            elif found is MotionState.ROLLING and rolling_ratio == 0.0:
                how = ", rolling or creeping: the radius of the string is not known"
            elif found is MotionState.CREEPING or (found is MotionState.ROLLING and ratio < 0.0):
                how = f", slip {abs(1.0 - ratio / rolling_ratio):.2f} of the rim speed"
            elif contact > criteria.CONTACT_FRACTION:
                how = ", sliding along the wall"
            return f"{orbit_text} ({sense}){how}, in contact {100 * contact:.0f} % of the time"


AT_START = "; there from the start of what is analysed, so its onset was before"
"""Note beside the criterion of such an onset."""
UNDOUBTED = frozenset((MotionState.NOT_OBSERVABLE, MotionState.AT_REST))
"""States that do not depend on what the samples can show."""
TURNING = 0.5
"""The string turned already: least rotation until then over that since the start; chosen, not measured."""


class Decisions:
    """Onset and motion states with their texts."""

    def __init__(self, names: tuple[str, ...], state: Columns, *, contact_known: bool = True) -> None:
        self._state, self._names, self._contact_known = state, names, contact_known
        self._detector = OnsetDetector(state)
        self._candidates: list[tuple[Crossing, bool]] = []
        self.onset: Onset | None = None
        """The onset, once it is decided."""
        self.crossed: list[float | None] = [None] * len(names)
        """Time at which each mark first crossed its threshold [s]."""
        self.criterion = ["no rotation seen yet"] * (len(names) + 1)
        """The criterion that decided the state of each mark and of the string, as text."""
        self.timelines = [Timeline() for _ in self.criterion]
        """States of the marks and of the string over time."""
        self.decide: dict[int, Callable[[], None]] = {
            CHECK: self._check,
            DECIDE: self._decide_onset,
            CROSSED: self._check_synchronous,
            DESCRIBE: self._describe_states,
        }
        """Decisions by the outcome of `analysis_loop.analyse`."""

    def doubt(self, mark: int) -> str:
        """Reason why the findings at a mark are not definite; empty where they are."""
        state = self._state
        return doubt(float(state.carrier.samples[mark]), float(state.marks.rolling_ratio[mark]))

    @property
    def rolling_ratio(self) -> float:
        """Largest whirl ratio in pure rolling of the marks that whirled; 0 where none did."""
        whirled = [any(period.state not in NO_WHIRL for period in one.periods) for one in self.timelines[:-1]]
        return float(self._state.marks.rolling_ratio[whirled].min(initial=0.0))

    @property
    def origin(self) -> float:
        """Time of the first sample [s]."""
        return float(self._state.samples.origin[0])

    def _check(self) -> None:
        """Check the newest bin for a whirl that begins."""
        crossings = self._detector.check()
        for crossing in crossings:
            if crossing.refit is not None:
                correct(self._state.separation, crossing.mark, crossing.refit)
        self._record(crossings, synchronous=False)
        self._restart_separation(self._detector.moved)

    def _check_synchronous(self) -> None:
        """Check the newest orbit for a synchronous whirl that begins, and for whirls that have ended."""
        state = self._state
        crossings = synchronous_begins(
            state.synchronous, state.marks.clearance, state.averaged.level, state.orbit, state.history
        )
        self._record(crossings, synchronous=True)
        self._restart_separation(self._detector.release())

    def _restart_separation(self, marks: list[int]) -> None:
        """Estimate offset and synchronous part of marks from the last revolution alone."""
        history = self._state.history
        window = newest(history, newest_in(history, 1.0))
        for mark in marks:
            fit_anew(self._state.separation, mark, history.position[window, mark], history.phasor[window, mark])

    def _record(self, crossings: list[Crossing], *, synchronous: bool) -> None:
        """Record first crossings of the marks; until the onset is decided, each crossing is a candidate."""
        for crossing in crossings:
            if self.crossed[crossing.mark] is None:
                self.crossed[crossing.mark] = self.origin + crossing.time
            if self.onset is None:
                self._candidates.append((crossing, synchronous))
                self._state.flow.undecided[0] = True

    def _decide_onset(self) -> None:
        """Set the onset to the earliest crossing, once no undecided mark may have crossed earlier."""
        # To the microsecond: of marks that cross together the first is named, whatever the round-off.
        first, synchronous = min(self._candidates, key=lambda candidate: round(candidate[0].time, 6))
        if self._detector.earliest_candidate(exclude=self._state.synchronous.active) < first.time:
            return
        at_start, why = self._at_start(first.time), self.doubt(first.mark)
        self.onset = Onset(
            time_s=self.origin + first.time,
            mark=self._names[first.mark],
            confidence=first.confidence * float(self._state.carrier.definite[first.mark]),
            kind="synchronous" if synchronous else "asynchronous",
            detected_s=self.origin + float(self._state.full.time[0]),
            criterion=f"{first.criterion}{AT_START if at_start else ''}{f'; {why}' if why else ''}",
            at_start=at_start,
        )
        self._state.flow.undecided[0], self._state.flow.new[0] = False, True
        self._state.statistics.whirled[0] = True
        self.timelines[-1].move_first_whirl(self.onset.time_s)

    def _at_start(self, time: float) -> bool:
        """Return True if a time [s] is in the first revolution, with a string that turned already."""
        history = self._state.history
        window = newest(history, history.length.item())
        seconds, revolutions = history.time[window], history.revolutions[window]
        turned = float(np.interp(time, seconds, revolutions))
        usual = float(revolutions[-1] - revolutions[0]) / max(float(seconds[-1] - seconds[0]), 1e-9)
        return turned < 1.0 and history.length[0] == history.appended[0] and turned > TURNING * usual * time

    def date_onset(self, onset: Onset) -> None:
        """Replace the onset by the same with a time that is known better."""
        self.onset = onset
        self.crossed[self._names.index(onset.mark)] = onset.time_s
        self.timelines[-1].move_first_whirl(onset.time_s)

    def _describe_states(self) -> None:
        """Put the states that have changed or settled into words."""
        state, motion = self._state, self._state.motion
        hysteresis, event = motion.hysteresis, motion.hysteresis.event.tolist()
        for subject in sorted((s for s in range(len(event)) if event[s] != KEPT), key=lambda s: event[s]):
            mark, held = int(motion.mark[subject]), int(hysteresis.held[subject])
            found = STATES[held]
            text = criterion_text(found, state, mark, contact_known=self._contact_known)
            if found not in UNDOUBTED and (why := self.doubt(mark)):
                text = f"{text}; {why}"
            self.criterion[subject] = text
            if event[subject] == CHANGED:
                start = self.origin + float(hysteresis.since[subject, held])
                self.timelines[subject].start(found, start, text)
            else:
                self.timelines[subject].describe(text)
