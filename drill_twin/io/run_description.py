# SPDX-License-Identifier: Apache-2.0
"""Text of `/twin/scene`, by which a bag tells what was run."""

from __future__ import annotations

from datetime import UTC, datetime

import yaml

from drill_twin.core.version import __version__
from drill_twin.dynamics.twin.twin import Twin


def describe_run(twin: Twin, pace: str = "fast") -> str:
    """Text of `/twin/scene`: the resolved scene (YAML) with a `run` block of version, seed, resolution and effects.

    Args:
        twin: The twin.
        pace: Pace of the run: realtime, fast or lockstep.
    """
    run = {
        "version": __version__,
        "seed": int(twin.scene.numerics.seed),
        "elements": int(twin.elements),
        "step_s": float(twin.step_size),
        "effects": [str(name) for name in twin.effects],
        "pace": pace,
        "started": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }
    return f"{twin.scene.to_yaml().rstrip()}\n{yaml.safe_dump({'run': run}, sort_keys=False)}"
