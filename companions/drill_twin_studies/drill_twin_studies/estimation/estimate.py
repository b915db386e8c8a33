# SPDX-License-Identifier: Apache-2.0
"""A window of what is measured, and the estimate at its end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame import Frame
from drill_twin_studies.estimation.doubts import Span, told_of_spans
from drill_twin_studies.estimation.jumps import told_of_jumps
from drill_twin_studies.estimation.prediction import Band
from drill_twin_studies.goodness import Goodness


@dataclass(frozen=True)
class FilterWindow:
    """Set-points and measured samples of a window of time.

    Attributes:
        commands: Set-points at the end of each frame, as `Command.values`, shape (F, 3).
        measured: Samples by channel, shape (S,) each; NaN where there is none.
        weights: Share of each frame in the time of a sample, of the C channels, shape (C, `WindowTiming.tail` + F, S):
            frames of a member times them are what is to be compared; 0 where there is no sample.
        readings: Of s subs, at the frames, shape (s, F, 6); NaN for a sub that has none.
        spacing: Usual time from sample to sample of the channels that show torsion [s]; NaN where it is not known.
        between: True for a window without samples, in which none was due.
    """

    commands: Array
    measured: Mapping[str, Array]
    weights: Array
    readings: Array | None = None
    spacing: float = math.nan
    between: bool = False


@dataclass(frozen=True)
class Estimate:
    """Estimate at the end of a window.

    Attributes:
        time: Time [s].
        numbers: Free numbers [SI] by key.
        untold: Share of its range that the band of a number covers, of those that the record does not tell, by key.
        sensors: Virtual sensors by name, see `drill_twin.io.messages.topic_words.SENSORS`; with a sub also the
            places of the centre line at the marks at the end of the window [m], MARK/x and MARK/y.
        withheld: Reason why a virtual sensor has no band, and no mean, by name.
        whirls: Share of the members that whirl.
        chance: Share of those that whirl within the horizon; NaN if it is not computed.
        unexplained: Time since which a channel is not explained [s], by name; virtual sensors are withheld then.
        jumps: Time of a jump [s] by key, of numbers that are being looked for anew; of `UNEXPLAINED`, if none explains
            it.
        misfit: Rms of measured less predicted over the scale, by channel; NaN where nothing was measured.
        goodness: How well the members explain each channel over the last windows, against the stated errors, by name.
        absurd: Samples left out so far.
        unmeasured: Time for which nothing sound has been measured [s]: the ensemble runs alone.
        frames: The window of the member that was nearest to the rig before; none unless they are asked for.
        spans: Windows with an alarm so far.
    """

    time: float
    numbers: Mapping[str, Band]
    untold: Mapping[str, float]
    sensors: Mapping[str, Band]
    withheld: Mapping[str, str]
    whirls: float
    chance: float
    unexplained: Mapping[str, float]
    jumps: Mapping[str, float]
    misfit: Mapping[str, float]
    goodness: Mapping[str, Goodness]
    absurd: int
    unmeasured: float
    frames: Sequence[Frame]
    spans: Sequence[Span] = ()

    @property
    def alarm(self) -> str:
        """Sentences while the members do not explain what is measured; empty while they do."""
        parts = [f"{name} since {time:.1f} s" for name, time in self.unexplained.items()]
        told = [f"the model does not explain {', '.join(parts)}: virtual sensors are withheld"] if parts else []
        told += filter(None, [told_of_jumps(self.jumps)])
        causes = "the motion has changed, or the rig differs from the model"
        return f"{'; '.join(told)}; {causes}" if told else ""

    @property
    def remembered(self) -> str:
        """Sentence on all windows with an alarm so far, whether one stands or not; empty without."""
        return told_of_spans(self.spans)
