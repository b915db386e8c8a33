# SPDX-License-Identifier: Apache-2.0
"""The fit: `python -m drill_twin_evidence.rotor_kit.fit RECORDS.csv FIT.json`, the same answer at each run."""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin_evidence.rotor_kit import records
from drill_twin_evidence.rotor_kit.elements import Real
from drill_twin_evidence.rotor_kit.posterior import ALL, Measured, log_likelihood
from drill_twin_evidence.rotor_kit.rig import Rigs
from drill_twin_evidence.rotor_kit.sampler import Chains, sample

GROUPS, WALKERS, STEPS = 4, 120, 3000  # R-hat of the slowest unknown is then below 1.02, which the fit prints
DRAWS = 600  # kept in the file; a quantile at 5 % of so many scatters by a fifth of a standard deviation at most
SEED = 46
SOURCES = ("elements", "fit", "forecast", "posterior", "predict", "records", "rig", "runup", "sampler")
LARGEST_R_HAT = 1.05  # above this the command says that the chains do not agree (Gelman et al. 2013 ask for 1.1)


def run(measured: Measured, *, steps: int = STEPS, seed: int = SEED, groups: int = GROUPS) -> Chains:
    """Return the chains of the posterior."""
    return sample(
        lambda z: log_likelihood(z, measured), len(ALL), groups=groups, walkers=WALKERS, steps=steps, seed=seed
    )


def first_critical(rigs: Rigs) -> Real:
    """Return the speed of the first peak of the larger axis of motion at disc 2 [rpm], shape (n,)."""
    rotors, places = rigs.rotors(), rigs.disc_places()
    rpm = np.arange(1100.0, 3500.0, 10.0)
    height = np.stack([np.abs(rotors.unbalance_response(v * np.pi / 30, places)).sum(axis=(2, 3))[:, 1] for v in rpm])
    rising = (height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:])
    first = np.where(rising.any(axis=0), rising.argmax(axis=0) + 1, height.argmax(axis=0))
    result: Real = rpm[first]
    return result


def code_hash() -> str:
    """Return the hash of the sources of fit and predictions: what a number rests on beside the data."""
    total = hashlib.sha256()
    for name in SOURCES:
        total.update(name.encode() + (Path(__file__).parent / f"{name}.py").read_bytes())
    return total.hexdigest()


def quantiles(values: Real) -> list[float]:
    """Return the 5, 50 and 95 % quantile with five figures."""
    return [float(f"{q:.5g}") for q in np.quantile(values, [0.05, 0.5, 0.95])]


def document(path: Path, chains: Chains) -> dict[str, Any]:
    """Return the fit as a document: what it rests on, agreement of chains, unknowns with bands, draws."""
    z = np.round(chains.drawn(DRAWS, np.random.default_rng(SEED)), 5)
    r_hat = chains.r_hat()
    flat = chains.z.reshape(-1, len(ALL))
    return {
        "what": "posterior of the rotor kit's unknowns from BASE, A007 and A015 at 1,005 rpm",
        "credit": list(records.CREDIT),
        "rests_on": {"records_sha256": records.sha256(path), "code_sha256": code_hash(), "seed": SEED},
        "chains": {
            "groups": chains.z.shape[0],
            "walkers": chains.z.shape[2],
            "kept_steps": chains.z.shape[1],
            "accepted": round(chains.accepted, 4),
            "largest_r_hat": round(float(r_hat.max()), 4),
        },
        "first_critical_rpm": quantiles(first_critical(Rigs.of(z[:, :-2]))),
        "unknowns": [
            {
                "name": prior.name,
                "prior": [prior.law, prior.low, prior.high],
                "ground": prior.ground,
                "posterior_5_50_95": quantiles(prior.value(flat[:, i])),
                "narrowed_to": round(float(flat[:, i].std()), 3),  # 1: the data say nothing of it
                "r_hat": round(float(r_hat[i]), 4),
            }
            for i, prior in enumerate(ALL)
        ],
        "draws": z.tolist(),
    }


def printed(fit: dict[str, Any]) -> str:
    """Return the fit as text."""
    lines = [f"{'unknown':18s}{'5 %':>11s}{'50 %':>11s}{'95 %':>11s}  narrowed  R-hat"]
    for one in fit["unknowns"]:
        low, middle, high = one["posterior_5_50_95"]
        lines.append(
            f"{one['name']:18s}{low:11.4g}{middle:11.4g}{high:11.4g}{one['narrowed_to']:10.2f}{one['r_hat']:7.3f}"
        )
    low, middle, high = fit["first_critical_rpm"]
    lines.append(f"first critical speed {low:.0f} to {high:.0f} rpm, median {middle:.0f}")
    worst = fit["chains"]["largest_r_hat"]
    lines.append(f"largest R-hat {worst:.3f}" + ("" if worst < LARGEST_R_HAT else ": the chains do not agree"))
    return "\n".join(lines)


def loaded(path: Path) -> tuple[dict[str, Any], Real]:
    """Return a fit's document and its draws, shape (draws, unknowns).

    Raises:
        ValueError: if the file's unknowns differ from this code's.
    """
    fit = json.loads(path.read_text())
    names = [one["name"] for one in fit["unknowns"]]
    laws = [one["prior"] for one in fit["unknowns"]]
    if names != [prior.name for prior in ALL] or laws != [[p.law, p.low, p.high] for p in ALL]:
        raise ValueError(f"{path}: a fit of other unknowns or priors than this code has; fit again")
    return fit, np.array(fit["draws"])


def main() -> int:
    """Fit a record and write the posterior; exit code 1 if the chains do not agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path)
    parser.add_argument("fit", type=Path)
    given = parser.parse_args()
    measured = Measured.of(records.read(given.records))
    fit = document(given.records, run(measured))
    given.fit.write_text(json.dumps(fit) + "\n")
    print(printed(fit))
    return int(fit["chains"]["largest_r_hat"] >= LARGEST_R_HAT)


if __name__ == "__main__":
    raise SystemExit(records.told(main))
