# SPDX-License-Identifier: Apache-2.0
"""Figures of the evidence that pages state: of the hard scenes and of the exact checks, from `evidence/pages`."""

import json
from pathlib import Path
from typing import Any

from _printed.markdown import table

PAGES = Path(__file__).parents[2] / "evidence" / "pages"
HARD = {
    "load_300_n": "35 times the buckling load: a helix on the wall",
    "commands_jump": "set-points jump at every sample, -100 to 300 N",
    "friction_2": "friction of 2, sharp at 1 µm/s, speed through zero",
    "wall_1e12": "a wall harder than rock: impacts of microseconds",
    "steel_8000_m": "8,000 m of drill pipe",
    "folds": "wound up until it kinks: it must stop and say why",
}
"""Hard scenes that the README shows, and what is hard about them."""


def hard_scenes() -> str:
    """Table of some hard scenes in the spatial formulation, and the number of cases that are in order."""
    cases = _read("hard")["cases"]
    by_name = {case["name"]: case for case in cases}
    rows = [(f"`{name}`", what, _result(by_name[f"{name}[spatial]"])) for name, what in HARD.items()]
    right = sum(case["ok"] for case in cases)
    return f"{right} of {len(cases)} cases are in order, for example:\n\n" + table(
        ("scene", "what is hard", "result"), rows
    )


def exact_checks() -> str:
    """Number of exact checks and how many are within their tolerance, in a sentence."""
    cases = _read("verification")["cases"]
    rows = [row for case in cases for row in case["rows"]]
    beside, itself = ([row for row in rows if row["consistency"] is consistent] for consistent in (False, True))
    return (
        f"{_share(beside)} numbers beside formulas, zeros and tables are within their tolerance, and {_share(itself)}\n"
        f"that compare two parts of the twin, in {len(cases)} cases.\n"
    )


def _result(case: dict[str, Any]) -> str:
    if not case["ok"]:
        return "**not in order**"
    return "stopped, and said why" if "stopped" in case["verdict"] else f"{case['real_time_factor']:.2g} × real time"


def _share(rows: list[dict[str, Any]]) -> str:
    return f"{sum(row['ok'] for row in rows)} of {len(rows)}"


def _read(name: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((PAGES / f"{name}.json").read_text("utf-8"))
    return data
