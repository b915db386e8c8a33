# SPDX-License-Identifier: Apache-2.0
"""Drilled depth and rate of penetration for the diagnostics."""

from __future__ import annotations

from drill_twin.dynamics.twin.twin import Twin

_HOUR = 3600.0


class DrillingProgress:
    """Depth and rate of penetration of one twin."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._last = (twin.time, twin.drilled)

    def values(self) -> dict[str, str]:
        """Drilled depth [m] and rate of penetration since the last call [m/h]; empty if the bit does not drill."""
        if not {"bit_cutting", "bit_regenerative"}.intersection(self._twin.effects):
            return {}
        (last_time, last_depth), time, depth = self._last, self._twin.time, self._twin.drilled
        self._last = (time, depth)
        elapsed = time - last_time
        rate = (depth - last_depth) / elapsed if elapsed > 0.0 else 0.0
        return {"drilled_m": f"{depth:.6f}", "rate_of_penetration_m_h": f"{rate * _HOUR:.3f}"}
