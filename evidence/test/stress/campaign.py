# SPDX-License-Identifier: Apache-2.0
"""Random scenes by number over sets of effects that hold every pair, each with the energy audit; resumable.

    python evidence/test/stress/campaign.py --scenes 10000

Scene n has effects set n modulo the number of sets (`effect_sets.covering`), and all its numbers from the seed n. Each
result is one line of a file; a run that is broken off goes on behind the last whole line and ends with the same table.
The exit code is 1 if a scene is wrong, or more than 1 % of them were given up without a named physical reason.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import math
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[2] / "test" / "composition")]

import effect_sets  # noqa: E402  they lie beside the tests
from random_scenes import BYTES, Tape  # noqa: E402
from random_scenes import scene as drawn  # noqa: E402

import drill_twin  # noqa: E402
from drill_twin.core.errors import RunError  # noqa: E402
from drill_twin.core.files.json_files import JsonLines  # noqa: E402
from drill_twin.dynamics.twin.twin import Twin  # noqa: E402
from drill_twin.runs.ensemble.parts import frames_of, planned  # noqa: E402
from drill_twin.scene import Scene  # noqa: E402
from drill_twin_evidence.stress.bound import allowed_depth  # noqa: E402
from drill_twin_evidence.stress.run import MAX_ENERGY_ERROR, RunStatistics  # noqa: E402

FRAMES = 20
GIVEN_UP = 0.01
"""Share of the scenes that may be given up without a named physical reason."""
NOT_BALANCED, GAINED = "energy not accounted for", " added energy"
TOLERANCES = ("auto", 1e-7, 1e-9)
HALVINGS = 3
"""A scene whose energy balance does not close to a tenth of the energy in motion, or to which a dissipative effect adds
energy, runs again with these tolerances of Newton's method, and then with the step halved, at most so often."""
FINER = (0, 2, 4, 6, 8)
"""Halvings of the step with which `--look` runs a scene."""
ROUND = 1000
"""Scenes of a round: all sets take their turn in each, so that a part of the campaign holds every set."""
REASONS = {
    "folded back": "folds", "leaned": "leans", "stretched or squeezed": "over-strained",
    "faster than any string": "faster than sound",
}  # fmt: skip
"""Words of the step guard for what the scene asks for and no string bears, and their names in the table."""
SETS = [
    frozenset(on | ({"torsion"} if "stretch" in on else set()))
    for on in effect_sets.covering()
    if not on & set(effect_sets.APART)  # numbers of scenes in evidence/docs/random_scenes.md are of these sets
]


class Result(NamedTuple):
    """Result of a scene."""

    number: int
    outcome: str  # ran, refused, stopped, given up or wrong
    reason: str  # a name of REASONS, or a sentence
    steps: int
    iterations: int
    halvings: int
    refined: int  # how often it ran again for the energy balance
    depth: float  # largest penetration of the wall over that allowed; 0 without a wall or contact
    energy: float  # largest error of the energy balance, over the largest energy in motion


def result_of(number: int) -> Result:
    """Run a scene of the campaign; where its energy is not accounted for, again with a finer iteration and step."""
    data = scene_data(number)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        said = error.errors()[0]["msg"]
        reason = "strains its material" if "it strains section" in said else said
        return Result(number, "refused", reason, 0, 0, 0, 0, 0.0, 0.0)
    step = Twin(scene).step_size
    for refined in range(len(TOLERANCES) + HALVINGS):
        if refined:
            data["numerics"]["tolerance"] = TOLERANCES[min(refined, len(TOLERANCES) - 1)]
            halved = 0.5 ** max(refined + 1 - len(TOLERANCES), 0) * step
            data["numerics"]["step"] = min(halved, 0.1) if halved < step else "auto"  # 0.1 s: the longest of a scene
            scene = Scene.model_validate(data)
        result = run_scene(number, scene, refined)
        if result.reason != NOT_BALANCED and not result.reason.endswith(GAINED):
            break
    return result


def scene_data(number: int) -> dict[str, Any]:
    """Scene of a number, with the energy audit, as plain data."""
    data: dict[str, Any] = drawn(Tape(np.random.default_rng(number).bytes(BYTES)).draw, SETS[number % len(SETS)])
    data["numerics"]["audit"] = "energy"
    return data


def look(number: int) -> str:
    """The error of a scene's energy at ever finer steps: it falls with the step, or it has another cause."""
    data, lines = scene_data(number), []
    step = Twin(Scene.model_validate(data)).step_size
    data["numerics"]["tolerance"] = TOLERANCES[-1]
    for halvings in FINER:
        data["numerics"]["step"] = min(step * 0.5**halvings, 0.1) if halvings else "auto"
        found = run_scene(number, Scene.model_validate(data), 0)
        lines.append(
            f"scene {number}, step / {2**halvings}: {found.outcome} {found.reason}, {found.steps} steps, energy error "
            f"{found.energy:.2g}"
        )
    return "\n".join(lines)


def run_scene(number: int, scene: Scene, refined: int) -> Result:
    """Run a scene once."""
    twin, found, stopped = Twin(scene), RunStatistics(), ""
    try:
        for frames in frames_of(twin, *planned(scene, FRAMES / scene.numerics.frame_rate), 1):  # with an energy audit
            found.add(frames)
    except RunError as error:
        stopped = str(error)
    bound = allowed_depth(twin, found.speed)
    # twice: as in the tests of single scenes; and the way of one step, since contact is evaluated at its ends
    depth = max(found.depth, 0.0) / (2.0 * bound + twin.step_size * found.speed) if math.isfinite(bound) else 0.0
    outcome, reason = verdict(found, depth, stopped)
    return Result(
        number, outcome, reason, found.steps, found.iterations, found.cut_steps, refined, round(depth, 4),
        float(f"{found.energy or 0.0:.3g}"),
    )  # fmt: skip


def verdict(found: RunStatistics, depth: float, stopped: str) -> tuple[str, str]:
    """Outcome and reason of a run."""
    if not found.finite:
        return "wrong", "not finite"
    if depth > 1.0:
        return "wrong", "deeper in the wall than allowed"
    if found.gained:
        return "wrong", found.gained + GAINED
    if found.energy is not None and found.energy > MAX_ENERGY_ERROR:
        return "wrong", NOT_BALANCED
    if not stopped:
        return "ran", ""
    known = next((name for words, name in REASONS.items() if words in stopped), None)
    return ("stopped", known) if known else ("given up", stopped)


def physics() -> str:
    """Hash of the code that decides the results: effects, model, solver, and what draws the scenes."""
    package = Path(drill_twin.__file__).parent
    rooms = (
        "physics/effects",
        "physics/model",
        *(f"dynamics/{room}" for room in ("solver/lateral", "solver/spatial", "twin")),
    )
    files = [path for room in rooms for path in sorted((package / room).glob("*.py"))]
    files += [package / "dynamics" / "solver" / name for name in ("boundary.py", "midpoint.py")]
    files += [HERE / "random_scenes.py", Path(effect_sets.__file__)]
    digest = hashlib.sha256()
    for path in files:
        digest.update(ast.dump(ast.parse(path.read_text("utf-8"))).encode())
    return digest.hexdigest()[:16]


def order(scenes: int) -> Iterator[int]:
    """Numbers in the order in which they run: round by round, set by set, so that a kernel is loaded once a round."""
    for start in range(0, scenes, ROUND):
        yield from sorted(range(start, min(start + ROUND, scenes)), key=lambda number: (number % len(SETS), number))


def run(scenes: int, path: Path) -> list[Result]:
    """Run what the file does not hold yet; returns all results by number."""
    setup = {"physics": physics(), "sets": len(SETS)}
    file = JsonLines(path, Result, "campaign", setup, remedy="remove it, or give another by --results")
    known = {result.number: result for result in file.results}
    for number in order(scenes):
        if number not in known:
            known[number] = result_of(number)
            file.add(known[number])
    return [known[number] for number in sorted(known) if number < scenes]


def table(results: Sequence[Result]) -> str:
    """The results by set, as Markdown."""
    columns = ("set", "effects", "scenes", "ran", "refused", "stopped, named", "given up", "wrong",
               "refined", "iterations a step", "halvings a step", "energy error")  # fmt: skip
    lines = [columns, ("---",) * len(columns)]
    for index, names in [*enumerate(SETS), (None, frozenset())]:
        mine = [result for result in results if index is None or result.number % len(SETS) == index]
        count = Counter(result.outcome for result in mine)
        steps = max(sum(result.steps for result in mine), 1)
        lines.append((
            "all" if index is None else str(index), ", ".join(f"`{name}`" for name in sorted(names)), str(len(mine)),
            *(str(count[key]) for key in ("ran", "refused", "stopped", "given up", "wrong")),
            str(sum(result.refined > 0 for result in mine)),
            f"{sum(result.iterations for result in mine) / steps:.1f}",
            f"{sum(result.halvings for result in mine) / steps:.2f}",
            f"{max((result.energy for result in mine), default=0.0):.1e}",
        ))  # fmt: skip
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def report(results: Sequence[Result]) -> str:
    """The table, named reasons, and scenes that were given up or are wrong."""
    named = Counter(result.reason for result in results if result.outcome == "stopped")
    odd = [result for result in results if result.outcome in {"given up", "wrong"}]
    text = table(results) + "\n\nStopped: " + (", ".join(f"{n} {name}" for name, n in named.most_common()) or "none")
    return "\n".join([text + ".", *(f"* scene {result.number}: {result.outcome}: {result.reason}" for result in odd)])


def main(words: Sequence[str] | None = None) -> int:
    """Run the campaign and print its table."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--scenes", type=int, default=10_000, help="number of scenes")
    parser.add_argument("--results", type=Path, default=Path("out/random_scenes.jsonl"), help="file of results")
    parser.add_argument("--look", type=int, nargs="+", help="numbers of scenes to run at ever finer steps instead")
    given = parser.parse_args(words)
    if given.look:
        print(*map(look, given.look), sep="\n")
        return 0
    results = run(given.scenes, given.results)
    print(report(results))
    count = Counter(result.outcome for result in results)
    return 1 if count["wrong"] or count["given up"] > GIVEN_UP * len(results) else 0


if __name__ == "__main__":
    sys.exit(main())
