# SPDX-License-Identifier: Apache-2.0
"""Whirl from the readings of one downhole sub, reading by reading: the analysis of its section as of a mark."""

import math
from dataclasses import replace

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.whirl import criteria
from drill_twin.whirl.analyzer import Analyzer
from drill_twin.whirl.criteria import BitMotion, MotionState
from drill_twin.whirl.decisions import AT_START
from drill_twin.whirl.downhole.dating import date_onset
from drill_twin.whirl.downhole.high_pass import ToolNoise
from drill_twin.whirl.downhole.motion import CALIBRATION, Place, SubMotion
from drill_twin.whirl.findings import Findings, Onset, Quality, SubFindings, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo

LARGEST = 1e6
"""Readings are below this [m/s^2, rad/s]; others are skipped as incomplete. Far above the range of such sensors;
chosen, not measured."""
FEWEST = criteria.FEWEST_SAMPLES
WAITING = f"no {CALIBRATION:g} revolutions at a steady speed so far"


class SubAnalyzer:
    """Finds whirl in the readings of a sub.

    Stick-slip is found for the section of the sub, from the sub's gyroscope.
    """

    def __init__(self, mark: MarkInfo, radius: float, noise: ToolNoise) -> None:
        """Begin before the first reading.

        Args:
            mark: The section, as a mark on the centre.
            radius: Distance of the sensor from the axis of the collar [m].
            noise: Noise of the instruments.
        """
        self.mark, self._noise = mark, noise
        self.motion = SubMotion(radius, mark.clearance, noise)
        """Lateral motion of the section."""
        self.place: Place | None = None
        """Newest place of the section; None before the first."""
        self._analyzer = Analyzer([mark], contact_known=False, top_known=False)
        self._duplicate = self._late = self._incomplete = 0
        self._last = -1
        self._dated = False
        self.findings = self._without_place(self._analyzer.findings)
        """The findings so far."""

    @property
    def quality(self) -> Quality:
        """Counts of readings analysed and skipped."""
        skipped = {"duplicate": self._duplicate, "late": self._late, "incomplete": self._incomplete}
        return self._analyzer.quality._replace(**skipped)

    def push(self, stamp: int, values: Array) -> Findings:
        """Add a reading and return the findings after it.

        Args:
            stamp: Middle of the reading [ns].
            values: Specific force [m/s^2] and rates [rad/s] in the axes of the sub, shape (6,).
        """
        reading = values.tolist()
        if stamp <= self._last:
            self._duplicate += stamp == self._last
            self._late += stamp < self._last
        elif not all(-LARGEST < value < LARGEST for value in reading):
            self._incomplete += 1
        else:
            self._last = stamp
            places = self.motion.push(stamp, reading)
            for place in places:
                self.place = place
                self.findings = self._analyse(place)
            if not places:
                found = self._analyzer.push_bit_speed(stamp, reading[5])
                self.findings = found if self.place else self._without_place(found)
            if self.findings.bit is BitMotion.STICK_SLIP:
                self.motion.torsion.push_sticking(*self._analyzer.bit_speed, self.motion.interval)
        return self.findings

    def summary(self) -> Summary:
        """The findings of the whole run so far."""
        return replace(self._analyzer.summary(), quality=self.quality, sub=self.sub)

    @property
    def sub(self) -> SubFindings:
        """Impacts and stick-slip so far."""
        impacts, torsion = self.motion.impacts, self.motion.torsion
        peaks = impacts.peaks
        return SubFindings(
            impacts.count,
            impacts.count / impacts.seconds if impacts.seconds else None,
            max(peaks, default=None),
            math.fsum(peaks) / len(peaks) if peaks else None,
            torsion.share_at_rest,
            torsion.radius,
            self.motion.corner / math.tau or None,
        )

    def checked_summary(self) -> Summary:
        """The findings of the whole run.

        Raises:
            AnalysisError: The readings hold too few revolutions without a gap.
        """
        if not self.quality.accepted:
            raise AnalysisError(
                f"expected over {CALIBRATION:g} revolutions of a sub without a gap, of {FEWEST:g} readings or more, "
                f"found {self.motion.revolutions:.2f}"
            )
        return self.summary()

    def _without_place(self, found: Findings) -> Findings:
        unknown = MotionState.NOT_OBSERVABLE
        return replace(found, state=(unknown,), criterion=(WAITING,), motion=unknown, motion_criterion=WAITING)

    def _analyse(self, place: Place) -> Findings:
        position = np.array([[place.position.real, place.position.imag]])
        found = self._analyzer.push(place.stamp, position, np.array([place.spin]), place.speed, None, place.speed)
        if found.onset is not None and not self._dated:
            self._dated = True
            self._date(found.onset)
            found = self._analyzer.findings
        return found

    def _date(self, onset: Onset) -> None:
        """Give the onset the time that the readings before and after it give together."""
        record = self.motion.record()
        date = date_onset(record, self.mark.clearance, self._noise, onset.time_s, onset.detected_s)
        uncertainty = max(date.time_s - date.earliest_s, date.latest_s - date.time_s)
        between = f"between {date.earliest_s:.2f} and {date.latest_s:.2f} s"
        note = f"; {between}" if date.dated else f"; not dated within a revolution: {between}"
        if date.first:
            note = AT_START if record.whole else "; not dated: it was before all that is kept of the readings"
        dated = replace(
            onset,
            time_s=min(date.time_s, onset.detected_s),
            uncertainty_s=None if date.first else uncertainty,
            dated=date.dated,
            criterion=f"{onset.criterion.removesuffix(AT_START)}{note}",
            at_start=date.first and record.whole,
        )
        self._analyzer.date_onset(dated)
