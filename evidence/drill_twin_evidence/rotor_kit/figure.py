# SPDX-License-Identifier: Apache-2.0
"""Figure of the predicted run-up: `python -m drill_twin_evidence.rotor_kit.figure RUN_UP.csv FIGURE.png`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, laid_out, styled
from drill_twin_evidence.rotor_kit.records import told
from drill_twin_evidence.rotor_kit.score import table_of


def drawn(rows: list[dict[str, str]]) -> Figure:
    """Return the amplitude at p1x over speed with its 90 % band."""
    rpm, middle, low, high = (np.array([float(row[name]) for row in rows]) for name in rows[0])
    with styled():
        figure = laid_out(3.6, "rotor kit: run-up at 229 rpm/s, predicted")
        axes = figure.subplots()
        axes.fill_between(rpm, low, high, color=BLUE, alpha=0.25, linewidth=0, label="90 % band")
        axes.plot(rpm, middle, color=BLUE, label="median")
        axes.set_yscale("log")
        axes.set_xlim(rpm[0], rpm[-1])
        axes.set_xlabel("speed [rpm]")
        axes.set_ylabel("amplitude at p1x [µm]")
        axes.legend()
        return figure


def main() -> int:
    """Write the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run_up", type=Path)
    parser.add_argument("figure", type=Path)
    given = parser.parse_args()
    drawn(table_of(given.run_up)).savefig(given.figure, dpi=110)
    return 0


if __name__ == "__main__":
    raise SystemExit(told(main))
