# SPDX-License-Identifier: Apache-2.0
"""Work over precision: the cost of each tool against its error, both logarithmic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from drill_twin.report.figures.style import BLUE, GREEN, GREY, INK, ORANGE, VERMILION, blank, head, save, styled

LOOKS = {
    "drill_twin": (BLUE, "o"),
    "Exudyn ANCF": (ORANGE, "s"),
    "MuJoCo flex": (GREEN, "^"),
    "PyElastica": (VERMILION, "D"),
}
NAMES = {
    "drill_twin": "drill_twin (stretch, bending, torsion)",
    "Exudyn ANCF": "Exudyn, ANCF cable (no torsion)",
    "MuJoCo flex": "MuJoCo, flex rod (clamps corrected)",
    "PyElastica": "PyElastica (clamps corrected)",
}
TITLES = {
    "smooth": "a pluck",
    "buckled": "buckled by 40 N",
    "contact": "turned, against the wall",
}

PALE = "pale: another setting of the tool is cheaper and more accurate"


def draw(results: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write the figure as PNG, a panel for each part that has errors."""
    parts = [result for result in results if result["reference"] is not None]
    with styled():
        figure = blank(4.9)
        head(figure, "What accuracy costs: error over processor time, one core")
        panels = figure.subplots(1, len(parts), squeeze=False, sharex=True, sharey=True)[0]
        figure.subplots_adjust(left=0.075, right=0.985, top=0.85, bottom=0.235, wspace=0.08)
        for panel, result in zip(panels, parts, strict=True):
            _panel(panel, result)
        panels[0].set_ylabel("error of the mid-span path, relative")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="lower center", ncols=2, bbox_to_anchor=(0.5, 0.0))
        figure.text(0.985, 0.955, PALE, ha="right", color=GREY, fontsize=9)
        save(figure, path)


def _panel(panel: Axes, result: Mapping[str, Any]) -> None:
    for tool, (colour, marker) in LOOKS.items():
        mine = [row for row in result["rows"] if row["tool"] == tool and not row["plain"] and not row["failure"]]
        rows = [row for row in mine if row["error"] and row["cost"]]
        rows.sort(key=lambda row: row["cost"])
        front = [row for k, row in enumerate(rows) if all(row["error"] < before["error"] for before in rows[:k])]
        looks = {"color": colour, "marker": marker, "markersize": 6}
        panel.loglog([r["cost"] for r in rows], [r["error"] for r in rows], linestyle="none", alpha=0.35, **looks)
        panel.loglog([r["cost"] for r in front], [r["error"] for r in front], linestyle="-", label=NAMES[tool], **looks)
    panel.axvline(1.0, color=INK, linewidth=0.9, linestyle=(0, (4, 2)))
    panel.annotate("real time", (1.0, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -10),
                   textcoords="offset points", fontsize=8.5, color=INK)  # fmt: skip
    panel.set_title(TITLES[result["part"]])
    panel.set_xlabel("CPU seconds per simulated second")
