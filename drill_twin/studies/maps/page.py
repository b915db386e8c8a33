# SPDX-License-Identifier: Apache-2.0
"""Page of an operating map: one HTML file that opens from disk."""

from __future__ import annotations

import json
from collections.abc import Iterable
from importlib.resources import files
from math import isfinite
from typing import Any

from drill_twin.core.arrays import Mask
from drill_twin.core.version import __version__
from drill_twin.scene.load import parse_scene
from drill_twin.studies.maps.operating_map import OperatingMap
from drill_twin.studies.maps.picture import WINDOW_COLOUR, boundaries, margins
from drill_twin.studies.maps.regimes import COLOURS, REGIMES

_LEFT_OUT = ("scene", "onset_boundary", "end_of_whirl_boundary")
"""Parts of `map.json` that the page has in another form, or not."""


def build_page(found: OperatingMap, scene: str) -> str:
    """HTML text of a map.

    Args:
        found: The map.
        scene: The scene with its options as on the command line, `pa6_bench --set hole.radius=80mm`, for the commands.
    """
    text = json.dumps(page_data(found, scene), allow_nan=False).replace("<", "\\u003c")
    return (files("drill_twin.studies.maps") / "page.html").read_text("utf-8").replace("/*DATA*/", text)


def page_data(found: OperatingMap, scene: str) -> dict[str, Any]:
    """Data that the page draws: the map, its fields over the lattice, and the command of each run."""
    rig = parse_scene(found.scene).rig
    own = [rig.weight_on_bit.value, rig.rotation.value]
    return lattice_data(found) | {
        **{name: value for name, value in found.to_dict().items() if name not in _LEFT_OUT},
        "version": __version__,
        "own": own,
        "whirling": [regime.value for regime in REGIMES if regime.whirls],
        "known": _digits(found.known),
        "calm": _digits(found.calm),
        "colours": COLOURS,
        "window_colour": WINDOW_COLOUR,
        "boundaries": [line._asdict() for line in boundaries(found)],
        "margins": [_finite(field.ravel().tolist()) for field in margins(found.calm)],
        "own_margin": _finite(found.margin(*own)) if found.contains(*own) else [],
        "commands": [found.command_of(key, scene) for key in found.records],
    }


def lattice_data(found: OperatingMap) -> dict[str, Any]:
    """Ranges, safe window, and fields over the lattice as one digit a node: the map without its runs."""
    window = found.window
    return {
        "scene_name": found.name,
        "digest": found.digest,
        "weight_on_bit_N": list(found.plane.weight),
        "rotation_rad_s": list(found.plane.speed),
        "steps": found.plane.steps,
        "regimes": [regime.value for regime in REGIMES],
        "codes": "".join(map(str, found.regimes.ravel().tolist())),
        "whirls": _digits(found.whirls),
        "keeps": _digits(found.keeps_whirling),
        "safe_window": None if window is None else [*window.weight, *window.speed],
    }


def _finite(values: Iterable[float]) -> list[float | None]:
    return [round(value, 6) if isfinite(value) else None for value in values]


def _digits(flags: Mask) -> str:
    return "".join("01"[flag] for flag in flags.ravel().tolist())
