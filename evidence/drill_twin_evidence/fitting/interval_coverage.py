# SPDX-License-Identifier: Apache-2.0
"""Share of random twins whose hidden numbers lie in their 90 % intervals: `make fit-coverage`.

Each twin turns the scene `two_mass` with hidden friction for 15 s; its bit speed, with noise, is the record.
A line of JSON for each twin is kept; a campaign that was broken off goes on from there.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats
from typing_extensions import TypedDict

import drill_twin as dt
from drill_twin.core.files.json_files import JsonLines

OVERRIDES: dict[str, float | str] = {"wob": 55e3, "numerics.step": "20 ms", "numerics.frame_rate": 10.0}
RANGES = {"bit_torque_stribeck.sticking": (0.55, 0.95), "bit_torque_stribeck.decay": (0.2, 6.0)}
FOREIGN, OTHER = "expected results of this campaign, found another file", "expected the same {}; give another file"
LENGTH, NOISE, LEVEL = 15.0, 0.05, 0.9


class Twin(TypedDict):
    """Fit to one twin."""

    seed: int
    hidden: dict[str, float]
    inside: dict[str, bool]
    runs: int
    power: float


def cover(seed: int) -> dict[str, Any]:
    """Fit one random twin; tells which intervals hold the hidden number."""
    generator = np.random.default_rng((seed, 18))
    hidden = {key: float(generator.uniform(*span)) for key, span in RANGES.items()}
    made = dt.Ensemble("two_mass", {key: [value] for key, value in hidden.items()}, overrides=OVERRIDES).run(
        LENGTH, outputs="channels", mark_rate=10.0
    )
    noisy = made["bit_speed"][0] + NOISE * generator.standard_normal(made["time"].size)
    record = dt.Record(f"twin {seed}", {"bit_speed": (made["time"] - 0.05, noisy)})
    found = dt.fit(
        record, "two_mass", RANGES, overrides=OVERRIDES, end=LENGTH, rate=10.0, members=32, rounds=30, seed=seed
    )
    inside = {
        key: found.quantile(key, 0.5 - LEVEL / 2) <= value <= found.quantile(key, 0.5 + LEVEL / 2)
        for key, value in hidden.items()
    }
    return {"seed": seed, "hidden": hidden, "inside": inside, "runs": len(found.values), "power": found.sampling.power}


def main(twins: int, journal: Path) -> None:
    """Fit the twins that the journal lacks, and print the shares."""
    lines: list[dict[str, Any]] = []
    file = JsonLines(journal, "fit coverage", {"ranges": RANGES}, lines.append, foreign=FOREIGN, other=OTHER, of=Twin)
    for seed in sorted(set(range(twins)) - {line["seed"] for line in lines}):
        lines.append(cover(seed))
        file.add(lines[-1])
    for key in RANGES:
        held = stats.binomtest(sum(line["inside"][key] for line in lines), len(lines))
        low, high = held.proportion_ci(0.95)
        print(
            f"{key}: {held.statistic:.1%} of {len(lines)} intervals of 90 % hold the hidden number; "
            f"95 % interval of the share {low:.1%} to {high:.1%}"
        )
    runs, wide = np.mean([line["runs"] for line in lines]), sum(line["power"] < 1.0 for line in lines)
    print(f"{runs:.0f} runs a fit; {wide} of {len(lines)} ended with draws wider than the record allows")


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
