# SPDX-License-Identifier: Apache-2.0
"""How far and how fast a run drills, for the diagnostics; nothing where the scene's bit does not drill."""

from __future__ import annotations

from drill_twin.twin.twin import Twin

_HOUR = 3600.0


class DrillingProgress:
    """Depth and rate of penetration of one twin."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._last = (twin.time, twin.drilled)

    def values(self) -> dict[str, str]:
        """For the diagnostics: the depth drilled [m], and the rate of penetration since the last report [m/h]."""
        if "bit_cutting" not in self._twin.effects:
            return {}
        (since, from_depth), now = self._last, (self._twin.time, self._twin.drilled)
        self._last = now
        passed = now[0] - since
        rate = (now[1] - from_depth) / passed if passed > 0.0 else 0.0
        return {"drilled_m": f"{now[1]:.6f}", "rate_of_penetration_m_h": f"{rate * _HOUR:.3f}"}
