# SPDX-License-Identifier: Apache-2.0
"""Signals of the gateway: unit, meaning and class, and the feature and the incident of D-WIS of each."""

from _printed.markdown import code, table
from drill_twin_rig.gateway.dwis import PROTOTYPES, facts
from drill_twin_rig.gateway.quantities import QUANTITIES
from drill_twin_rig.gateway.signals import read_signals, signals_path


def signals() -> str:
    """Table of the signals of the file `dwis`."""
    rows = []
    for signal in read_signals(signals_path("dwis")).show:
        known = dict(facts(signal.kind, signal.quantity))
        terms = [signal.kind if signal.kind in PROTOTYPES else "", known["BelongsToClass"]]
        terms += [known.get(f"IsRelatedToDrilling{kind}", "") for kind in ("Incident", "Limit")]
        shown = " ".join(code(one) for one in terms if one not in {"", "ComputedData"})
        meaning = QUANTITIES[signal.quantity].meaning.replace("precession", "whirl speed")
        rows.append((code(signal.name), signal.unit, meaning, shown, code(known.get("AccountsFor", ""))))
    return table(("signal", "unit", "meaning", "terms of D-WIS", "`AccountsFor`"), rows)
