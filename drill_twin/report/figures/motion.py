# SPDX-License-Identifier: Apache-2.0
"""Motion states over time, and the precession that decides them."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from drill_twin.report.figures.style import (
    GREY,
    INK,
    RIGHT,
    STATE_COLOURS,
    draw_onset,
    mark_style,
    note,
    over_time,
)
from drill_twin.report.recording import Recording
from drill_twin.whirl import Criteria, MotionPeriod, MotionState

_ROW = 0.34
_ROOM = 11
"""Number of letters of a name that fit beside the bands."""
_LETTER = 0.0078
"""Width of a letter, as a share of the time axis."""


def motion(recording: Recording) -> Figure:
    """Bands of motion states of the string and of each mark; below, signed precession over rotation."""
    summary = recording.summary
    rows = {"string": summary.motion, **summary.mark_motion}
    figure, (bands, ratio) = over_time(recording.duration, [_ROW * len(rows), 1.9], title="Motion state and precession")
    for row, periods in enumerate(rows.values()):
        _band(bands, row, periods, recording.duration)
    bands.set_ylim(len(rows) - 0.5, -0.5)
    longest = max(len(name) for name in rows)
    bands.set_yticks(range(len(rows)), list(rows), fontsize=min(10.5, 10.5 * _ROOM / longest))
    bands.grid(visible=False)
    bands.tick_params(length=0)
    for side in ("left", "bottom"):
        bands.spines[side].set_visible(False)
    _ratio(ratio, recording)
    draw_onset(summary.onset, recording.duration, [bands, ratio])
    _legend(figure, [period.state for periods in rows.values() for period in periods])
    return figure


def _band(panel: Axes, row: int, periods: tuple[MotionPeriod, ...], end: float) -> None:
    starts = [0.0, *(period.start_s for period in periods[1:])]
    for start, stop, period in zip(starts, [*starts[1:], end], periods, strict=False):
        name = period.state.value
        panel.barh(row, stop - start, left=start, height=0.78, color=STATE_COLOURS[period.state], linewidth=0,
                   gid=f"{name}, {start:.2f} to {stop:.2f} s")  # fmt: skip
        if (stop - start) / max(end, 1e-9) > _LETTER * len(name):
            dark = period.state in {MotionState.ROLLING, MotionState.REVERSE_WHIRL}
            panel.text(
                0.5 * (start + stop), row, name, ha="center", va="center", fontsize=9, color="white" if dark else INK
            )


def _ratio(panel: Axes, recording: Recording) -> None:
    time, ratios = recording.whirl.time, recording.whirl.ratio
    clearance = np.array([place.clearance for place in recording.places])
    large = recording.whirl.orbit_radius > Criteria().onset_radius * clearance
    for mark, name in enumerate(recording.findings.marks):
        panel.plot(time, ratios[:, mark], linewidth=0.8, alpha=0.25, **mark_style(mark))
        wide = np.where(large[:, mark], ratios[:, mark], np.nan)
        panel.plot(time, wide, linewidth=1.5, label=name, **mark_style(mark))
    seen = ratios[large & np.isfinite(ratios)]
    low, high = np.percentile(seen, [1.0, 99.0]) if seen.size else (0.0, 1.0)
    panel.set_ylim(max(min(low - 0.1, -0.3), -3.0), min(max(high + 0.1, 1.25), 3.0))
    panel.axhline(0.0, color=GREY, linewidth=1.0)
    panel.axhline(1.0, color=GREY, linewidth=1.0, linestyle="--")
    looks = {"ha": "right", "va": "bottom", "fontsize": 8.5, "color": GREY}
    note(panel, "as fast as the string turns", (1.0, 1.0), where=("axes fraction", "data"), shift=(-3, 2), **looks)
    panel.set_ylabel("precession / rotation\n- backward, + forward")
    share = f"{100 * Criteria().onset_radius:g} %"
    panel.set_title(f"Precession over rotation (faint: within {share} of the clearance)", fontsize=10.5, pad=4)
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(6, ratios.shape[1]), borderaxespad=0.2)


def _legend(figure: Figure, states: list[MotionState]) -> None:
    shown = [state for state in MotionState if state in states]
    handles = [Patch(color=STATE_COLOURS[state], label=state.value) for state in shown]
    columns = math.ceil(len(handles) / (1 if len(handles) <= 4 else 2))
    figure.legend(handles=handles, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=columns, borderaxespad=0.3,
                  handlelength=1.0, columnspacing=1.2)  # fmt: skip
