# SPDX-License-Identifier: Apache-2.0
"""Predictions beside a record: `python -m drill_twin_evidence.rotor_kit.score RECORDS.csv PREDICTIONS.csv`.

Counted as the issue says: p2x and p2y, minus the session's baseline, net unbalance of 20 g mm or more, doubtful
conditions and the fitted ones left out. The baseline of a session comes from the least-squares superposition of the
record itself, so no prediction enters into what it is held against.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin_evidence.rotor_kit import records
from drill_twin_evidence.rotor_kit.elements import Complex
from drill_twin_evidence.rotor_kit.records import COUNTED, DOUBTFUL, FITTED, LEAST_NET, PROBES, Records


def counted_rows(data: Records) -> list[int]:
    """Return the rows of labelled first repeats that are neither doubtful nor fitted."""
    return [row for row in data.firsts(sealed=False) if data.condition[row] not in (*DOUBTFUL, *FITTED)]


def baselines(data: Records) -> dict[str, Complex]:
    """Return the baseline of each session [um], shape (4,), by superposition over its labelled conditions."""
    rows = [row for row in data.firsts(sealed=False) if data.condition[row] not in DOUBTFUL]
    sessions = sorted({data.session[row] for row in rows})
    held = np.array([[data.session[row] == name for name in sessions] for row in rows], float)
    matrix = np.concatenate([data.unbalance[rows], held], axis=1)
    found = np.linalg.lstsq(matrix, data.vectors[rows], rcond=None)[0]
    return {name: found[2 + i] for i, name in enumerate(sessions)}


def scores(data: Records, predicted: list[dict[str, str]], probes: tuple[int, ...] = COUNTED) -> dict[str, Any]:
    """Return rms errors of amplitude [%] and phase [deg], and the part inside the bands, of vectors minus baseline."""
    table = {(row["condition"], row["probe"]): row for row in predicted}
    base = baselines(data)
    amplitude, phase, inside, whole = [], [], [], []
    for row in counted_rows(data):
        net = data.vectors[row] - base[data.session[row]]
        for probe in probes:
            said = table[data.condition[row], PROBES[probe]]
            whole += _held(said, data.vectors[row, probe], "")
            if np.abs(data.unbalance[row].sum()) < LEAST_NET:
                continue
            amplitude.append(float(said["amp_um_net"]) / np.abs(net[probe]) - 1)
            phase.append(_apart(np.rad2deg(np.angle(net[probe])), float(said["phase_deg_net"])))
            inside += _held(said, net[probe], "_net")
    return {
        "vectors": len(amplitude),
        "amplitude_rms_percent": round(100 * float(np.sqrt(np.mean(np.square(amplitude)))), 2),
        "phase_rms_deg": round(float(np.sqrt(np.mean(np.square(phase)))), 2),
        "held_percent": round(100 * float(np.mean(inside)), 1),
        "held_percent_of_whole_vectors": round(100 * float(np.mean(whole)), 1),
    }


def _apart(one: float, other: float) -> float:
    """Return the angle from other to one [deg], from -180 to 180."""
    return (one - other + 180) % 360 - 180


def _held(said: dict[str, str], vector: complex, suffix: str) -> list[bool]:
    """Return whether amplitude and phase lie inside their bands."""
    size = float(said[f"amp_low{suffix}"]) <= abs(vector) <= float(said[f"amp_high{suffix}"])
    middle = float(said[f"phase_deg{suffix}"])
    off = _apart(float(np.rad2deg(np.angle(vector))), middle)
    angle = float(said[f"phase_low{suffix}"]) - middle <= off <= float(said[f"phase_high{suffix}"]) - middle
    return [size, angle]


def table_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a file of predictions."""
    with path.open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def main() -> int:
    """Print the scores."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("records", type=Path)
    parser.add_argument("predictions", type=Path)
    given = parser.parse_args()
    data, predicted = records.read(given.records), table_of(given.predictions)
    for name, probes in (("p2x and p2y", COUNTED), *((probe, (i,)) for i, probe in enumerate(PROBES))):
        print(name, scores(data, predicted, probes))
    return 0


if __name__ == "__main__":
    raise SystemExit(records.told(main))
