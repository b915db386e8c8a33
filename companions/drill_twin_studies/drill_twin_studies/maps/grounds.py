# SPDX-License-Identifier: Apache-2.0
"""Grounds of the windows of a map, as sentences."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from drill_twin.core.severity import DEFAULT, OF_THIS_PROGRAM, WORDS
from drill_twin.scene.load import parse_scene
from drill_twin_studies.maps.fields import MARGIN, MapFields
from drill_twin_studies.maps.plane import corners
from drill_twin_studies.maps.proportions import none_of
from drill_twin_studies.maps.runs import GRADED

ROUNDS = 4
"""Most rounds of checks, each in the windows that the rounds before left. The first round without failure is the last,
so that one of so many looks is reported; not measured."""


def calm_means(found: MapFields) -> str:
    """Meaning of calm, with the bounds of the scene and their source."""
    own = parse_scene(found.scene).severity if found.scene else None
    bounds, source = (own.bounds if own else DEFAULT)._asdict(), own.whose if own else OF_THIS_PROGRAM
    said = "; ".join(
        f"{WORDS[name]} {found.units.text(bounds[name][1], unit, '.3g') if unit else bounds[name][1]}"
        for name, unit in GRADED.items()
    )
    return f"calm: no whirl but creeping, settled, and below medium, which begins at {said} (bounds: {source})"


def grounds(found: MapFields) -> Iterator[str]:
    """Grounds of the windows of a map; none without windows."""
    inside = found.window_cells
    if not inside.any():
        return
    nodes = np.asarray(corners(np.pad(inside, 1)).any(axis=0))
    runs = [run for node, at_node in found.runs_at_nodes.items() if nodes[node] for run in at_node]
    kinds = ", ".join(f"{count} {kind}" for kind, count in Counter(run.regime.value for run in runs).items())
    yield (
        f"{len(runs)} runs of {found.duration:g} s in them and at their corners, all calm ({kinds}): none would "
        f"cease to be calm within {found.asked:g} s if it went on growing as at its end"
    )
    yield calm_means(found)
    largest = float(found.largest_growth[nodes].max())
    if largest > -np.inf:
        yield f"the straight string, where it is on the axis, does not grow in them (largest rate {largest:.2g} 1/s)"
    else:
        yield "linear growth is not known for this scene, so nothing is known between its runs"
    if found.has_second_boundary:
        yield "a whirl that exists dies or creeps in them, on the way that was tried"
    else:
        yield "whether a whirl that exists dies in them was not searched"
    drawn = [(nodes[node], len(at_node)) for node, at_node in found.runs_at_nodes.items() if len(at_node) > 1]
    if whole := sum(within and count == len(found.draws) for within, count in drawn):
        most = none_of(len(found.draws) - 1, len(drawn))
        yield (
            f"at {whole} of their set-points none of {len(found.draws)} draws whirls: the chance of whirl is below "
            f"{most:.1%} at all of these together (95 %, after {len(drawn)} looks)"
        )
    if count := found.clean_checks:
        most = none_of(count, ROUNDS)
        yield (
            f"{count} more runs of {found.asked:g} s at set-points drawn in them are calm: at most {most:.1%} of their "
            f"set-points are not (95 %, after up to {ROUNDS} rounds)"
        )
    else:
        yield (
            f"no round of runs of {found.asked:g} s in them ended without failure, so what share of their set-points "
            "is calm is not known"
        )
    yield f"they keep {MARGIN:.0%} of the ranges to what is not calm or not known; nothing of this is of a rig"
