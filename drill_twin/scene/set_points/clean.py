# SPDX-License-Identifier: Apache-2.0
"""Cleaning of measured set-points: spikes removed, gaps interpolated, both counted."""

from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import TableError

CORE = 0.5
"""Least deviation of a spike's peak from the running median, over the 5 to 95 percentile range [-]."""
FLANK = 0.1
"""Least deviation of its other samples from the median, over the same range [-]."""
SCATTER = 6.0
"""Least deviation in standard deviations of the scatter about the median [-]."""


@dataclass(frozen=True)
class Cleaning:
    """Counts of the corrections to one column."""

    spikes: int = 0
    """Number of spikes removed."""
    spike_samples: int = 0
    """Samples in them."""
    gaps: int = 0
    """Number of gaps interpolated."""
    gap_samples: int = 0
    """Samples missing in them, at the record's median spacing."""
    longest_gap: float = 0.0
    """Longest gap interpolated [s]."""


def clean(time: Array, values: Array, *, name: str, longest_gap: float, spike_window: float) -> tuple[Array, Cleaning]:
    """Remove spikes and gaps from one column, shape (rows,), and count them; `time` [s] must increase.

    Raises:
        TableError: No value at all, or a gap longer than `longest_gap`.
    """
    spacing = float(np.median(np.diff(time)))
    valid = np.isfinite(values)
    if valid.sum() < 2:
        raise TableError(f"{name}: expected at least two finite values, found {int(valid.sum())}")
    gaps = _gaps(time, valid, spacing)
    too_long = [(begin, end) for begin, end in gaps if end - begin > longest_gap]
    if too_long:
        begin, end = too_long[0]
        raise TableError(
            f"{name}: expected gaps of at most {longest_gap:g} s, found {len(too_long)} longer, the first from "
            f"{begin:.6g} s to {end:.6g} s; raise `longest_gap` to bridge it"
        )
    spikes = np.zeros(len(values), dtype=bool)
    spikes[valid] = find_spikes(values[valid], window=round(spike_window / spacing))
    good = valid & ~spikes
    cleaned = np.interp(time, time[good], values[good])
    return cleaned, Cleaning(
        spikes=_runs(spikes),
        spike_samples=int(spikes.sum()),
        gaps=len(gaps),
        gap_samples=sum(max(1, round((end - begin) / spacing) - 1) for begin, end in gaps),
        longest_gap=max((end - begin for begin, end in gaps), default=0.0),
    )


def find_spikes(values: Array, *, window: int) -> Mask:
    """Mask of the samples in spikes: excursions from a running median over `window` samples, shape (rows,).

    A window below three samples finds none.
    """
    from scipy.ndimage import label, median_filter

    if window < 3 or len(values) < window:
        return np.zeros(len(values), dtype=bool)
    distance = np.abs(values - median_filter(values, window | 1, mode="nearest"))
    low, high = np.percentile(values, [5.0, 95.0])
    scatter = SCATTER * 1.4826 * float(np.median(distance))
    core = distance > max(CORE * (high - low), scatter)
    region, _ = label(distance > max(FLANK * (high - low), scatter))
    return np.isin(region, np.unique(region[core]))


def _gaps(time: Array, valid: Mask, spacing: float) -> list[tuple[float, float]]:
    """Start and end of the intervals without a value that exceed the median spacing by half or more."""
    known = time[valid]
    edges = [(float(known[i]), float(known[i + 1])) for i in np.flatnonzero(np.diff(known) > 1.5 * spacing)]
    if known[0] > time[0]:
        edges.insert(0, (float(time[0]), float(known[0])))
    if known[-1] < time[-1]:
        edges.append((float(known[-1]), float(time[-1])))
    return edges


def _runs(mask: Mask) -> int:
    return int(np.count_nonzero(np.diff(np.concatenate(([False], mask)).astype(np.int8)) == 1))
