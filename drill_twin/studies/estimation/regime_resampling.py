# SPDX-License-Identifier: Apache-2.0
"""Resampling by regime: members that swing while the rig does not, or the other way, take the state of others.

Where two motions are possible with the same numbers (stick-slip beside steady rotation), a filter for near-linear
motion does not lead from one to the other. So the size of the swing in windows is compared, which does not depend on a
phase, and members are weighted with it (importance weights of a particle filter, on features instead of samples).
"""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array

_MEMORY = 5.0
"""Windows over which the weights fade."""
_WIDTH = 0.7
"""Standard deviation of the logarithm of a swing: a factor of 2."""
_UNLIKELY = 1e-3
"""Weight over the largest one, below which a member is replaced."""


class RegimeResampling:
    """Weights of N members by the swings of their channels."""

    def __init__(self, members: int, seed: int) -> None:
        self.logarithm: Array = np.zeros(members)
        self._generator = np.random.default_rng(seed)

    def weigh(self, predicted: Array, measured: Array, deviation: Array) -> None:
        """Take a window.

        Args:
            predicted: Channels of the members, shape (N, C, S).
            measured: Channels, shape (C, S); NaN where missing.
            deviation: Of the errors of a sample, shape (C,): a smaller swing is none.
        """
        for channel, error in enumerate(deviation):
            known = np.isfinite(measured[channel])
            if known.sum() < 0.5 * known.size:
                continue
            seen = np.log(measured[channel, known].std() + error)
            swings = np.log(predicted[:, channel, known].std(axis=1) + error)
            self.logarithm -= 0.5 * ((swings - seen) / _WIDTH) ** 2
        self.logarithm *= 1.0 - 1.0 / _MEMORY

    def replacements(self) -> list[tuple[int, int]]:
        """Pairs (source, target) of members: likely ones, drawn by weight, in place of those that are not any more."""
        weights = np.exp(self.logarithm - self.logarithm.max())
        targets = np.flatnonzero(weights < _UNLIKELY)
        likely = np.where(weights < _UNLIKELY, 0.0, weights)
        sources = self._generator.choice(weights.size, targets.size, p=likely / likely.sum())
        self.logarithm[targets] = self.logarithm[sources]
        return list(zip(sources.tolist(), targets.tolist(), strict=True))
