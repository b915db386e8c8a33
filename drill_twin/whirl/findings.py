# SPDX-License-Identifier: Apache-2.0
"""Results of the analysis: the state after each sample, and the summary of a run."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.files.plain_json import plain
from drill_twin.whirl.criteria import BitMotion, MotionCode, MotionState


@dataclass(frozen=True)
class Onset:
    """The onset of whirl (the paper's critical time)."""

    time_s: float
    """Time at which the radius first crossed its threshold [s]."""
    mark: str
    """Mark with the earliest crossing."""
    confidence: float
    """Rank from 0 to 1, no probability: 1 less the chance that noise is as large, times the coherence of the angle.
    Of 200 kinematic records no onset above 0.99 was half a revolution off, and 4 of 22 below 0.5 were."""
    kind: Literal["asynchronous", "synchronous"]
    """Part of the motion that crossed its threshold."""
    detected_s: float
    """Time of detection [s]: about a revolution later, more where a mark crossed before but swept its angle later."""
    criterion: str
    """Criterion that decided the onset, as text."""
    uncertainty_s: float | None = None
    """From a downhole sub: the true onset is so near in nine of ten cases or more [s]; None where not estimated."""
    dated: bool = True
    """False where the time is not known within a revolution."""
    at_start: bool = False
    """True where the string whirled in the first revolution of the record, turning already: the onset was before."""


@dataclass(frozen=True)
class MotionPeriod:
    """Period of one motion state."""

    start_s: float
    """Start [s]; it ends where the next period starts."""
    state: MotionState
    """Motion state."""
    criterion: str
    """Criterion that decided the state, as text."""


@dataclass(frozen=True)
class StickSlipPeriod:
    """Period of stick-slip."""

    start_s: float
    """Start of its first cycle [s]."""
    end_s: float
    """End of its last cycle [s]."""
    cycles: int
    """Cycles in the period."""
    period_s: float
    """Mean length of a cycle [s]."""
    shortest_s: float
    longest_s: float
    """Shortest and longest cycle [s]."""
    slowest_rad_s: float
    fastest_rad_s: float
    """Slowest and fastest speed of the bit, low-passed [rad/s]."""
    severity: float
    """Mean of (fastest - slowest) / (2 mean) over its cycles."""

    @property
    def frequency_hz(self) -> float:
        """Frequency of the cycles [Hz]."""
        return 1.0 / self.period_s


class Quality(NamedTuple):
    """Counts of samples analysed and skipped."""

    accepted: int = 0
    """Samples analysed."""
    duplicate: int = 0
    """Samples skipped because their stamp equals the last one."""
    late: int = 0
    """Samples skipped because their stamp is before the last one."""
    incomplete: int = 0
    """Samples skipped: no finite rotation, spin missing, or no mark with finite values."""
    missing_marks: int = 0
    """Marks skipped within samples: not finite, or farther out than three clearances."""
    gaps: int = 0
    """Gaps of more than 3/4 of a revolution or a second between accepted samples."""
    samples_per_revolution: float = math.nan
    """Mean number of accepted samples in a revolution since rotation began."""


@dataclass(frozen=True, eq=False)
class Findings:
    """State of the analysis after a sample; arrays have shape (m,), one value for each mark."""

    stamp_ns: int
    """Stamp of the sample [ns]."""
    time_s: float
    """The same [s]."""
    marks: tuple[str, ...]
    """Names of the marks."""
    orbit_radius: Array
    """Distance of the centre line from the hole's axis [m]; nan for a mark without a valid sample."""
    precession: Array
    """Precession of the centre line [rev/s], positive = forward (the sense of rotation); nan while the radius is too
    small. Of the asynchronous part during whirl, otherwise of the motion about the offset."""
    ratio: Array
    """Whirl ratio; nan as above, and at rest."""
    confidence: Array
    """Clearness of precession and ratio, a rank from 0 to 1 and no probability: coherence, less the share of noise."""
    state: tuple[MotionState, ...]
    """Motion state of each mark."""
    criterion: tuple[str, ...]
    """The criterion that decided each mark's state, as text."""
    motion: MotionState
    """Motion state of the string."""
    motion_criterion: str
    """Criterion that decided the motion state, as text."""
    bit: BitMotion
    """Motion of the bit, by its stick-slip index."""
    bit_criterion: str
    """Criterion that decided the bit's motion, as text."""
    onset: Onset | None
    """The onset, once it is detected; it never changes afterwards."""
    quality: Quality
    """Counts of good and bad samples."""
    bit_index: float = math.nan
    """Stick-slip index of the bit; nan while it is not known."""

    @property
    def codes(self) -> list[int]:
        """Codes of the motion states of the marks (`MotionCode`)."""
        return [MotionCode.of(state) for state in self.state]


class FoundRows(NamedTuple):
    """Findings after each of n samples."""

    before: Findings
    """Findings before the first."""
    stamps: list[int]
    """Stamp of the findings [ns]."""
    values: Array
    """Orbit radius [m], precession [rev/s], ratio and confidence of each mark, shape (n, m, 4)."""
    bit_index: Array
    """Stick-slip index of the bit, shape (n,); nan while it is not known."""
    changes: dict[int, Findings]
    """Findings by the number of a sample after which a state, a text or the onset may be another."""

    @classmethod
    def of(cls, findings: Findings) -> FoundRows:
        """Findings after one sample."""
        columns = findings.orbit_radius, findings.precession, findings.ratio, findings.confidence
        values = np.stack(columns, axis=-1)[None]
        return cls(findings, [findings.stamp_ns], values, np.array([findings.bit_index]), {0: findings})

    def states(self) -> Array:
        """Values of `/whirl/state`: as `values`, precession in [rad/s], and the `MotionCode`, shape (n, m, 5)."""
        codes, begin, present = np.empty((*self.values.shape[:2], 1)), 0, self.before
        for row in sorted(self.changes):
            codes[begin:row, :, 0], begin, present = present.codes, row, self.changes[row]
        codes[begin:, :, 0] = present.codes
        states = np.concatenate((self.values, codes), axis=-1)
        states[..., 1] *= math.tau
        return states


@dataclass(frozen=True)
class SubFindings:
    """Findings of a downhole sub beside whirl."""

    impacts: int
    """Impacts on the wall (`drill_twin.whirl.downhole.sub_findings`)."""
    impact_rate_hz: float | None
    """Impacts in a second."""
    largest_impact: float | None
    """Largest lateral acceleration of an impact, mean over a reading [m/s^2]."""
    mean_impact: float | None
    """Mean over the impacts of their largest [m/s^2]."""
    share_at_rest: float | None
    """Share of the time of stick-slip in which the section is at rest; None without stick-slip."""
    radius_m: float | None
    """Distance of the sensor from the axis by its readings; None where the speed varies too little."""
    slowest_hz: float | None
    """Slowest whirl that the readings show [Hz]; None before the first place of the section."""


@dataclass(frozen=True)
class Summary:
    """The findings of a whole run."""

    onset: Onset | None = None
    """The onset of whirl, if there was one."""
    mark_onset_s: dict[str, float | None] = field(default_factory=dict)
    """Time at which each mark's radius crossed its threshold [s]."""
    whirl_frequency_hz: float | None = None
    """Mean precession over `whirl_frequency_window_s` [Hz], positive = forward, at `frequency_mark`; None where the
    motion that lasts is irregular and has no single one (`drill_twin.whirl.frequency`)."""
    whirl_ratio: float | None = None
    """The same over the rotation."""
    whirl_frequency_window_s: tuple[float, float] | None = None
    """Time of the mean [s]: the settled part of the whirl, or most of a whirl that still changes or is irregular."""
    whirl_frequency_interval_hz: tuple[float, float] | None = None
    """Interval that holds the frequency of a settled whirl in nine of ten cases; of any other whirl, least and largest
    mean of a window. None for too short a whirl."""
    whirl_frequency_changes: bool | None = None
    """True if the frequency still changes; None for irregular motion and for too short a whirl."""
    frequency_mark: str | None = None
    """Mark with the largest whirl relative to its clearance, whose frequency is reported."""
    max_radius_m: dict[str, float | None] = field(default_factory=dict)
    """Largest distance of the centre line from the hole's axis at each mark [m]."""
    rotation_rev_s: float | None = None
    """Mean rotation while the string rotated, since the onset if there was one [rev/s]."""
    motion: tuple[MotionPeriod, ...] = ()
    """Motion states of the string over time."""
    mark_motion: dict[str, tuple[MotionPeriod, ...]] = field(default_factory=dict)
    """Motion states of each mark over time."""
    stick_slip: tuple[StickSlipPeriod, ...] = ()
    """Periods of stick-slip of the bit."""
    bit: BitMotion = BitMotion.UNKNOWN
    """Motion of the bit at the end."""
    quality: Quality = Quality()  # noqa: RUF009  a named tuple, which nobody changes
    """Counts of good and bad samples."""
    notes: tuple[str, ...] = ()
    """Limits of these findings, as sentences."""
    stick_slip_index: float | None = None
    """Stick-slip index of the bit over the last 20 s (`whirl.motion.stick_slip_index`); None where not known."""
    largest_stick_slip_index: float | None = None
    """Largest such index of the run."""
    lasting_motion: MotionState | None = None
    """State of the string for most of the second half of the time since the onset, or of the record without one."""
    whirl_end_s: float | None = None
    """Time since which the string has not whirled any more [s]: the whirl was a transient; None where it whirls at the
    end of the record, or never did."""
    mean_frequency_hz: float | None = None
    """`whirl_frequency_hz`, for irregular motion too: there it depends on the length of the record [Hz]."""
    mean_ratio: float | None = None
    """`whirl_ratio`, for irregular motion too."""
    irregular_share: float | None = None
    """Share of the power of the whirl since the onset, at `frequency_mark`, in neither of the two strongest lines of up
    to 12 revolutions (`orbit.two_lines`): small for one whirl or two, large for motion without order or while it grows
    or changes. None without a whirl."""
    observable: bool = True
    """False if there were no positions of marks, so that whirl is not observable."""
    sub: SubFindings | None = None
    """Impacts and stick-slip by a downhole sub, where its readings were analysed."""

    @property
    def onset_s(self) -> float | None:
        """Time of the onset [s]."""
        return None if self.onset is None else self.onset.time_s

    def to_dict(self) -> dict[str, Any]:
        """The summary in plain types for JSON; states by name, unknown numbers as None."""
        found: dict[str, Any] = plain({"onset_s": self.onset_s, **asdict(self), "quality": self.quality._asdict()})
        return found
