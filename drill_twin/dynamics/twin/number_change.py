# SPDX-License-Identifier: Apache-2.0
"""Other numbers of effects and drive for a twin in the middle of a run; its state stays."""

from __future__ import annotations

from typing import Any

import numpy as np

from drill_twin.dynamics.discretisation.kernel_arguments import parameters_of
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.scene import Scene


def change_numbers(dynamics: Dynamics, scene: Scene) -> None:
    """Take the numbers of another scene, which differs from that of the dynamics in effects and drive only.

    Parameters and memory of an effect share its arrays. What differs between the parameters of both scenes, each
    fresh, is a number and is replaced; the rest is memory and stays.

    Args:
        dynamics: Of a scene without an audit, whose ledger depends on no number.
        scene: The other scene, with the same kernel and string.
    """
    before, after = (parameters_of(dynamics.kernel, each, dynamics.model) for each in (dynamics.scene, scene))
    dynamics.scene = scene
    dynamics.set_parameters(_replaced(dynamics.parameters, before, after))


def _replaced(value: Any, before: Any, after: Any) -> Any:
    if isinstance(value, np.ndarray):
        same = (before == after) | (np.isnan(before) & np.isnan(after))  # NaN is memory too: nothing so far
        np.copyto(value, after, where=~same)
        return value
    if not isinstance(value, tuple):
        return after
    items = [_replaced(*trio) for trio in zip(value, before, after, strict=True)]
    return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
