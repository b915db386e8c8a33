# SPDX-License-Identifier: Apache-2.0
"""Missing values: what stands for no value in a record, and what no rig can have measured."""

from collections import deque
from collections.abc import Collection

import numpy as np
import numpy.typing as npt

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.rig_channels import FIELDS, RIG_CHANNELS

WORDS = frozenset((
    "", "nan", "na", "n/a", "#n/a", "null", "none", "nil", "-", "--", "---", "*", "inf", "-inf", "+inf", "nodata",
    "no data", "no value", "absent", "missing", "void", "bad", "#value!", "#ref!", "#div/0!", "#num!", "#name?",
    "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind", "1.#inf", "-1.#inf", "bad input", "not available",
))  # fmt: skip
"""Cells that stand for no value, lower case."""
CERTAIN = -999.25
"""Null value of LAS and WITSML, which no channel is taken to measure."""
OF_THE_TRADE = (
    -999.0, -999.99, -8888.0, -9999.0, -9999.25, -9999.99, -99999.0, -999999.0, -32767.0, -32768.0,
    999.25, 9999.0, 9999.25, 9999.99, 99999.0, 999999.0,
)  # fmt: skip
"""Numbers that rigs send for no value; a channel may pass through each, so the values around it decide."""
_SPAN, _SHARE = 0.5, 0.02
"""Distance from the other values beyond which such a number is a null: over their range, over the number itself."""
_JUMP, _STEP = 5.0, 0.1
"""Step to a null: over the 95th percentile of the steps, and over the range of the values."""
_NOISE, _RUN = 0.02, 3
"""Median step, over the range, of a channel so noisy that steps tell nothing: so many equal values are then nulls."""


class LiveChannel:
    """One channel whose values come one by one: the rule of `without_missing`, by the values before.

    What comes later, which decides in a file too, is unknown: before two other values have come, a number of the trade
    is left out that a file may keep; among noise, the first two of a run of nulls are kept that a file leaves out.
    """

    def __init__(self) -> None:
        self._before = deque[float](maxlen=600)  # a minute at 10 Hz; not measured

    def is_missing(self, value: float, *, keep: bool = True) -> bool:
        """True for a value that is no measurement; another is kept, if asked, and the next values are judged by it."""
        suspect = not np.isfinite(value) or value in {CERTAIN, *OF_THE_TRADE}
        suspect = suspect and [*self._before][-_RUN:] != [value] * _RUN  # such a run is kept, however long it lasts
        missing = suspect and bool(np.isnan(without_missing(np.array([*self._before, value]))[0][-1]))
        self._before.extend([value] * (keep and not missing))
        return missing


def beyond(name: str, values: npt.ArrayLike) -> tuple[Mask, str]:
    """Values [SI] that no rig can have in a channel, by any of its names, and a text on what the values are."""
    channel = RIG_CHANNELS.get(FIELDS.get(name, ""))
    low, high = channel.bounds if channel else (-np.inf, np.inf)
    found = np.asarray(values, np.float64)
    return (found < low) | (found > high), f"beyond any {channel.heading if channel else name}"


def left_out(what: str, rows: Mask) -> list[str]:
    """A text on values that are left out: how many, what and where; none where the mask is empty."""
    at = np.flatnonzero(rows) + 1
    return [f"{at.size} {what} ({f'rows {at[0]} to' if at.size > 1 else 'row'} {at[-1]})"] if at.size else []


def without_missing(values: Array, nulls: Collection[float] = ()) -> tuple[Array, list[str]]:
    """Values with NaN for what is no measurement, and texts on what was left out; the same for all readers.

    Args:
        values: One column over time.
        nulls: Null values that a file or the user gives, which are missing wherever they stand.
    """
    certain, blank = {CERTAIN, *nulls}, ~np.isfinite(values)
    told, numbers = left_out("without a number", blank), sorted({*certain, *OF_THE_TRADE})
    suspect = np.isin(values, numbers)
    others = np.where(blank | suspect, np.nan, values)
    kept = others.copy()
    for null in numbers if suspect.any() else ():
        at = values == null
        rows = at if null in certain or not at.any() else _nulls(at, others, null)
        kept[at & ~rows] = null
        told += left_out(f"of {null:g}", rows)
    return kept, told


def _nulls(at: Mask, others: Array, null: float) -> Mask:
    """Rows at which a number of the trade is no measurement: far from all other values, or from its neighbours."""
    if (known := others[np.isfinite(others)]).size < 2:
        return at
    low, span, steps = known.min(), np.ptp(known), np.abs(np.diff(known))
    if not abs(null - low - 0.5 * span) <= 0.5 * span + max(_SPAN * span, _SHARE * abs(null)):
        return at
    edges = np.flatnonzero(np.diff(at.astype(np.int8), prepend=0, append=0))
    begin, end = edges[::2], edges[1::2]
    beside = np.pad(others, 1, constant_values=np.nan)
    jump = np.fmax(np.abs(beside[begin] - null), np.abs(beside[end + 1] - null))
    noisy = np.median(steps) > _NOISE * span > 0.0
    isolated = jump > max(_JUMP * np.percentile(steps, 95.0), _STEP * span, _SHARE * abs(null))
    rows = np.zeros_like(at)
    rows[at] = np.repeat(isolated | (noisy & (end - begin >= _RUN)), end - begin)
    return rows
