# SPDX-License-Identifier: Apache-2.0
"""Draws of seed and uncertain numbers: the first is the scene as it is, the others fill their ranges evenly."""

from __future__ import annotations

from collections.abc import Mapping

from drill_twin.core.errors import ArgumentError
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at

SEED = "numerics.seed"
MOST = 1000
"""Largest number of draws."""


def draws_of(
    scene: Scene, seeds: int, vary: Mapping[str, tuple[float, float, str]]
) -> tuple[Mapping[str, float | str], ...]:
    """Values by key of each draw; empty where one draw is asked for and nothing varies.

    The points of a scrambled Sobol sequence (Owen 1998) fill the ranges.

    Args:
        scene: The base scene; its own numbers are the first draw.
        seeds: Number of draws.
        vary: Least and largest value by key, and their unit.

    Raises:
        ArgumentError: Too many draws, an empty range, or a key that has no number.
    """
    if not 1 <= seeds <= MOST:
        raise ArgumentError(f"seeds: expected 1 to {MOST}, found {seeds}")
    if vary and seeds == 1:
        raise ArgumentError("vary: expected 2 or more seeds with uncertain numbers, one draw for each; found 1")
    if seeds == 1:
        return ()
    from scipy.stats import qmc

    first: dict[str, float | str] = {SEED: scene.numerics.seed}
    keys = {}
    for name, (low, high, _) in vary.items():
        keys[name] = f"effects.{name}" if name.partition(".")[0] in scene.effect_names else name
        first[keys[name]] = _number(scene, keys[name])
        if not low < high:
            raise ArgumentError(f"vary: expected {name}=LOW..HIGH with LOW below HIGH, found {low:g} to {high:g}")
    draws = [first]
    points = qmc.Sobol(max(1, len(vary)), seed=0).random(1 << (seeds - 1).bit_length())
    for number, point in enumerate(points[: seeds - 1].tolist(), 1):
        draw: dict[str, float | str] = {SEED: scene.numerics.seed + number}
        for share, (name, (low, high, unit)) in zip(point, vary.items(), strict=False):
            value = low + (high - low) * share
            draw[keys[name]] = f"{value!r} {unit}" if unit else value
        draws.append(draw)
    return tuple(draws)


def _number(scene: Scene, key: str) -> float:
    """Value of a number of a scene in SI."""
    found = number_at(scene, key)
    if found is None:
        raise ArgumentError(f"vary: expected the key of a number of {scene.name}, found {key}")
    return found
