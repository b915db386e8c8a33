# SPDX-License-Identifier: Apache-2.0
"""Coverage of the bands of `fit --likelihood features`, and whether it tells a wrong model; twin against twin.

    python -m drill_twin_evidence.foreign_rigs.features_coverage

Records of `two_mass` in stick-slip, with hidden sticking torques and from a time that the runs do not have, so that
their phase is not that of any run. Runs are made once, and each fit takes 80 of them as its draws.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from drill_twin.api import Ensemble
from drill_twin.core.arrays import Array
from drill_twin_studies.fitting.likelihood import features_goodness, of_features
from drill_twin_studies.fitting.sampling import Sampling

KEY = "bit_torque_stribeck.sticking"
RANGE = (0.78, 0.99)
"""Torques at which the scene sticks and slips throughout."""
RUNS, DURATION, BEGIN, LATER, DRAWS = 210, 70.0, 25.0, 6.0, 80
"""Runs, their time [s], that from which they are compared, most by which a record begins later, runs of a fit."""


class Case(NamedTuple):
    """Fits of one kind."""

    name: str
    fits: int
    length: float
    """Time that is compared [s]."""
    window: float = 5.0
    noise: float = 0.02
    """Noise over the standard deviation of a record."""
    change: Callable[[Array], Array] | None = None
    """Error of the record; None for none."""


WRONG: dict[str, Callable[[Array], Array]] = {
    "10 % too large": lambda speed: 1.1 * speed,
    "30 % too large": lambda speed: 1.3 * speed,
    "offset by 0.3 standard deviations": lambda speed: speed + 0.3 * speed.std(),
}
CASES = [
    *(Case("right", 60, length) for length in (15.0, 20.0, 38.0)),
    Case("right", 40, 20.0, noise=0.0),
    Case("right", 40, 20.0, noise=0.1),
    Case("right", 40, 30.0, window=3.0),
    *(Case(name, 20, length, change=change) for length in (15.0, 20.0, 38.0) for name, change in WRONG.items()),
]


def fits(case: Case, period: float, torques: Array, speeds: Array) -> list[tuple[bool, bool]]:
    """Return whether the band of each fit holds the truth, and whether the fit is explained."""
    generator, found = np.random.default_rng(21), []
    size, begin = round(case.length / period), round(BEGIN / period)
    for _ in range(case.fits):
        truth = int(generator.integers(5, torques.size - 5))
        later = round((BEGIN + generator.uniform(0.0, LATER)) / period)
        speed = speeds[truth, later : later + size]
        speed = speed if case.change is None else case.change(speed)
        record = {"bit_speed": speed + case.noise * speed.std() * generator.standard_normal(size)}
        drawn = np.sort(generator.choice(np.delete(np.arange(torques.size), truth), DRAWS, replace=False))
        runs = {"bit_speed": speeds[drawn, begin : begin + size]}
        likelihood = of_features(record, runs, period, case.window)
        weights = np.exp(likelihood - likelihood.max())
        cube = ((torques[drawn] - torques[drawn][0]) / np.ptp(torques[drawn]))[:, None]
        low, high = Sampling(cube, weights / weights.sum(), likelihood, 1.0).intervals[:, 0]
        low, high = torques[drawn][0] + np.array([low, high]) * np.ptp(torques[drawn])
        best = {"bit_speed": runs["bit_speed"][np.argmax(likelihood)]}
        explained = features_goodness(record, best, period, case.window)["bit_speed"].explained
        found.append((bool(low <= torques[truth] <= high), explained))
    return found


def main() -> None:
    """Print a line for each case."""
    torques = np.linspace(*RANGE, RUNS)
    made = Ensemble("two_mass", {KEY: torques.tolist()}).run(DURATION, outputs=("channels",), mark_rate=20.0)
    period = float(made["time"][1] - made["time"][0])
    for case in CASES:
        found = fits(case, period, torques, made["bit_speed"])
        holds, explained = (sum(column) for column in zip(*found, strict=True))
        print(
            f"{case.name}, {case.length:g} s in windows of {case.window:g} s, noise {case.noise:g}: "
            f"{holds} of {case.fits} bands hold, {case.fits - explained} not explained",
            flush=True,
        )


if __name__ == "__main__":
    main()
