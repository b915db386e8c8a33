# SPDX-License-Identifier: Apache-2.0
"""Scores as the Markdown tables of `evidence/docs/detection.md`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from drill_twin.core.table import Table
from drill_twin_studies.maps.proportions import proportion_text

TARGETS = {"kinematic": 0.95, "simulated": 0.85, "simulated_with_forces": 0.85}
"""Required macro-F1."""
NAMES = {
    "kinematic": "kinematic signals",
    "simulated": "simulated runs, marks and top speed alone",
    "simulated_with_forces": "simulated runs, with wall forces",
}


def markdown(measured: dict[str, Any]) -> str:
    """Tables of a result in plain types (`Result.to_dict`)."""
    return "\n".join([*_onsets(measured), "", *_states(measured), ""])


def _onsets(measured: dict[str, Any]) -> Iterator[str]:
    heads = (
        "set", "records", "onsets", "within half a revolution", "missed", "false", "median error [rev]",
        "announced after [rev], median and 95 %",
    )  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for key, name in NAMES.items():
        one = measured["sets"][key]
        rows.append((
            name, one["records"], one["onsets"], f"{proportion_text(one['met'], one['onsets'])}; 95 % asked for",
            one["missed"], one["false"], _number(one["median_error_rev"]),
            f"{_number(one['median_delay_rev'])}, {_number(one['delay_95_rev'])}",
        ))  # fmt: skip
    sets = [measured["sets"][key] for key in ("kinematic", "simulated")]
    onsets = sum(one["onsets"] for one in sets)
    met = sum(one["met"] for one in sets)
    records = sum(one["records"] for one in sets)
    rows.append(("both sets", records, onsets, proportion_text(met, onsets), "", "", "", ""))
    yield Table(heads, rows).markdown()
    yield ""
    yield (
        f"Steady rotation with noise of 5 % of the clearance: {measured['plan']['hours']:g} h of four marks, "
        f"{measured['false_onsets']} onsets (0 asked for)."
    )


def _states(measured: dict[str, Any]) -> Iterator[str]:
    sets = {key: measured["sets"][key] for key in NAMES}
    heads = ["F1 of", *(head for key in sets for head in (f"{NAMES[key]}: string", "marks"))]
    rows = []
    states = [state for state in next(iter(sets.values()))["states"] if state not in {"at rest", "not observable"}]
    for state in states:
        cells = [_number(one[f"{level}_f1"].get(state)) for one in sets.values() for level in ("string", "marks")]
        if any(cell != "-" for cell in cells):
            rows.append([state, *cells])
    macro = []
    for key, one in sets.items():
        macro.append(f"**{_number(one['string_macro_f1'])}** ({TARGETS[key]} asked for)")
        macro.append(f"**{_number(one['marks_macro_f1'])}**")
    yield Table(heads, [*rows, ["macro-F1", *macro]]).markdown()


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
