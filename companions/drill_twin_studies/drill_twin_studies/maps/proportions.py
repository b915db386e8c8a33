# SPDX-License-Identifier: Apache-2.0
"""Limits of a chance from a count (Clopper and Pearson 1934)."""

CONFIDENCE = 0.9
"""Two-sided confidence of a count, of which the upper limit holds with 95 %."""


def proportion_interval(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Two-sided limits of the chance behind `count` of `trials`; (0, 1), nothing known, without trials.

    They hold at least as often as `confidence`, whatever the chance and however few the trials. The upper limit alone
    holds with a confidence of (1 + confidence) / 2, so that 0.9 gives the one-sided 95 % limit.

    >>> low, high = proportion_interval(41, 42)
    >>> round(low, 3), round(high, 4)
    (0.874, 0.9994)
    """
    from scipy.special import betaincinv

    outside = 0.5 * (1.0 - confidence)
    low = 0.0 if count == 0 else float(betaincinv(count, trials - count + 1, outside))
    high = 1.0 if count == trials else float(betaincinv(count + 1, trials - count, 1.0 - outside))
    return low, high


def none_of(trials: int, claims: int = 1) -> float:
    """Upper limit of the chance behind none of `trials`; of so many claims at once all hold with 95 % (Bonferroni),
    also where the claims that are said were chosen from them by their outcome.

    >>> round(none_of(59), 3), round(none_of(59, 4), 3)
    (0.05, 0.072)
    """
    return 1.0 - float((0.05 / max(claims, 1)) ** (1.0 / trials))
