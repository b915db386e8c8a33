# SPDX-License-Identifier: Apache-2.0
"""Counts with the limits of their chance in words."""

from drill_twin_studies.maps.proportions import proportion_interval


def proportion_text(count: int, trials: int, confidence: float = 0.95) -> str:
    """The count with its limits in words.

    >>> proportion_text(41, 42)
    '41 of 42 (95 % interval 87.4 to 99.9 %)'
    >>> proportion_text(0, 0)
    '0 of 0 (not known)'
    """
    if trials == 0:
        return "0 of 0 (not known)"
    low, high = (100.0 * limit for limit in proportion_interval(count, trials, confidence))
    return f"{count} of {trials} ({100.0 * confidence:.3g} % interval {low:.3g} to {high:.3g} %)"
