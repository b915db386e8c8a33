# SPDX-License-Identifier: Apache-2.0
"""The predictions: `python -m drill_twin_evidence.rotor_kit.predict RECORDS.csv FIT.json FOLDER`, repeatable.

Of the record only BASE, A007, A015 (through the fit and the base) and the vectors of the sealed conditions are used;
labels of the others say which weights to predict.
"""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin_evidence.rotor_kit import records
from drill_twin_evidence.rotor_kit.elements import Complex
from drill_twin_evidence.rotor_kit.fit import code_hash, loaded
from drill_twin_evidence.rotor_kit.forecast import Forecast, complex_normal
from drill_twin_evidence.rotor_kit.posterior import Measured
from drill_twin_evidence.rotor_kit.records import PROBES, Records
from drill_twin_evidence.rotor_kit.runup import COLUMNS, run_up

COPIES = 5  # predictive draws a draw of the posterior
SEED = 4646
BAND = (0.05, 0.5, 0.95)
VECTOR_COLUMNS = ("amp_um", "amp_low", "amp_high", "phase_deg", "phase_low", "phase_high")


def polar(vectors: Complex) -> list[float]:
    """Return amplitude and phase [deg], each as median and 90 % band, of draws of one vector, shape (n,)."""
    middle = np.angle(np.median(vectors.real) + 1j * np.median(vectors.imag))
    phase = np.rad2deg(middle + np.angle(vectors * np.exp(-1j * middle)))
    low, amplitude, high = np.quantile(np.abs(vectors), BAND)
    early, angle, late = np.quantile(phase, BAND)
    return [amplitude, low, high, angle, early, late]


def vector_rows(forecast: Forecast, data: Records, speed: int, rng: np.random.Generator) -> list[list[Any]]:
    """Return a row for each condition and probe: whole vector, and vector minus the session's base."""
    rows: list[list[Any]] = []
    for row in data.firsts(sealed=False) + (data.firsts(sealed=True) if speed else []):
        name = data.condition[row]
        if data.sealed[row]:
            mean = data.mean(name)
            unbalance, known = forecast.weights(mean, rng), "inferred"
        else:
            unbalance, known = np.broadcast_to(data.unbalance[row], (len(forecast.residual), 2)), "given"
        net = forecast.net(unbalance, speed, rng)
        whole = forecast.vectors(net, speed, rng)
        # The session's base is itself measured once or a few times: half of a mount's variance, chosen.
        moved = net + np.sqrt(0.5) * forecast.scatter * complex_normal(rng, net.shape)
        for probe, label in enumerate(PROBES):
            rows.append([name, data.session[row], known, label, *polar(whole[:, probe]), *polar(moved[:, probe])])
    return rows


def weight_rows(forecast: Forecast, data: Records, conditions: list[str], rng: np.random.Generator) -> list[list[Any]]:
    """Return a row for each condition and disc and for the sum: size and angle of the weight, with bands."""
    rows: list[list[Any]] = []
    for name in conditions:
        drawn = forecast.weights(data.mean(name), rng)
        for label, values in (("disc 1", drawn[:, 0]), ("disc 2", drawn[:, 1]), ("sum", drawn.sum(axis=1))):
            middle = np.median(values.real) + 1j * np.median(values.imag)
            near = float(np.quantile(np.abs(values - middle), 0.9))
            rows.append([name, label, *polar(values), middle.real, middle.imag, near])
    return rows


def written(path: Path, header: list[str], head: dict[str, Any], rows: list[list[Any]]) -> None:
    """Write rows of numbers with five figures below lines that say what they rest on."""
    with path.open("w", newline="") as file:
        for name, value in head.items():
            file.write(f"# {name}: {value}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        table.writerows([[f"{v:.5g}" if isinstance(v, float) else v for v in row] for row in rows])


def main() -> int:
    """Write the four predictions."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path)
    parser.add_argument("fit", type=Path)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    data, (fit, z) = records.read(given.records), loaded(given.fit)
    if fit["rests_on"]["records_sha256"] != records.sha256(given.records):
        raise ValueError(f"{given.fit} rests on another record than {given.records}; fit again")
    rng = np.random.default_rng(SEED)
    forecast = Forecast.of(np.repeat(z, COPIES, axis=0), Measured.of(data), rng)
    given.folder.mkdir(parents=True, exist_ok=True)
    head = {
        "bands": "5 and 95 %; _net is minus the session's base; um 0 to peak; phase and angle as lag, deg",
        "records_sha256": records.sha256(given.records),
        "fit_sha256": records.sha256(given.fit),
        "code_sha256": code_hash(),
        "seed": SEED,
        "credit": "; ".join(records.CREDIT),
    }
    columns = ["condition", "session", "weights", "probe", *VECTOR_COLUMNS, *(f"{c}_net" for c in VECTOR_COLUMNS)]
    for speed, rpm in enumerate(("1005", "1206")):
        rows = vector_rows(forecast, data, speed, rng)
        written(given.folder / f"rk4_vectors_{rpm}rpm.csv", columns, {"speed": f"{rpm} rpm"} | head, rows)
    sealed = [data.condition[row] for row in data.firsts(sealed=True)]
    weights = ["condition", "of", "size_gmm", "size_low", "size_high", "angle_deg", "angle_low", "angle_high"]
    weights += ["x_gmm", "y_gmm", "radius_90_gmm"]
    written(given.folder / "rk4_weights.csv", weights, head, weight_rows(forecast, data, sealed, rng))
    summary, curve = run_up(z, Measured.of(data), rng)
    (given.folder / "rk4_run_up.json").write_text(json.dumps(head | summary, indent=1) + "\n")
    written(given.folder / "rk4_run_up.csv", list(COLUMNS), head, curve)
    print(json.dumps(summary, indent=1))
    return 0


if __name__ == "__main__":
    raise SystemExit(records.told(main))
