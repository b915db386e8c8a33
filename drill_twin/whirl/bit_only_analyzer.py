# SPDX-License-Identifier: Apache-2.0
"""Analysis without positions of marks: stick-slip of the bit; whirl is not observable."""

from __future__ import annotations

import math

from drill_twin.core.arrays import number_or_none
from drill_twin.core.compile.jit import as_python
from drill_twin.whirl.findings import Quality, Summary
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.sample_bins import accept, is_new, new_clock, rotate, seconds_of

NOT_OBSERVABLE = "whirl is not observable: there are no lateral positions of marks"
_IS_NEW, _ACCEPT, _ROTATE = as_python(is_new), as_python(accept), as_python(rotate)


class BitOnlyAnalyzer:
    """Analysis of the speeds of top drive and bit, sample by sample."""

    def __init__(self) -> None:
        self.bit = StickSlip()
        """Stick-slip of the bit."""
        self._clock = new_clock(0)
        self._accepted = self._incomplete = 0

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        clock, revolutions = self._clock, self._clock.revolutions.item()
        rate = self._accepted / revolutions if revolutions > 0.0 else math.nan
        skipped = clock.duplicate.item(), clock.late.item(), self._incomplete
        return Quality(self._accepted, *skipped, samples_per_revolution=rate)

    def push(self, stamp_ns: int, top_speed: float, bit_speed: float) -> bool:
        """Add a sample at a header stamp [ns], speeds in [rad/s]; return whether the motion of the bit changed."""
        clock = self._clock
        if not _IS_NEW(clock, stamp_ns):
            return False
        if not (math.isfinite(top_speed) or math.isfinite(bit_speed)):
            self._incomplete += 1
            return False
        _ROTATE(clock, _ACCEPT(clock, stamp_ns), top_speed, clock.spin, has_spin=False)
        self._accepted += 1
        before = self.bit.motion
        self.bit.push(stamp_ns * 1e-9, bit_speed, top_speed)
        return self.bit.motion is not before

    def summary(self) -> Summary:
        """The findings so far."""
        seconds = as_python(seconds_of)(self._clock)
        return Summary(
            onset=None,
            mark_onset_s={},
            whirl_frequency_hz=None,
            whirl_ratio=None,
            frequency_mark=None,
            max_radius_m={},
            rotation_rev_s=self._clock.angle.item() / math.tau / seconds if seconds > 0.0 else None,
            motion=(),
            mark_motion={},
            stick_slip=tuple(self.bit.periods),
            bit=self.bit.motion,
            stick_slip_index=number_or_none(self.bit.index),
            largest_stick_slip_index=number_or_none(self.bit.largest_index),
            quality=self.quality,
            notes=(NOT_OBSERVABLE,),
            observable=False,
        )
