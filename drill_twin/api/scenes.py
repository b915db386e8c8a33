# SPDX-License-Identifier: Apache-2.0
"""Scenes for Python: load, build, change, check and write; quantities as arguments, in a unit of their own."""

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, DrillTwinError, SceneError
from drill_twin.core.files.output import write_whole, writing
from drill_twin.core.units import Dimension, UnitError, parse
from drill_twin.core.units.dimension import TIME
from drill_twin.core.units.parse import split
from drill_twin.core.units.ranges import parse_range
from drill_twin.scene import Scene, load, presets
from drill_twin.scene.load import override
from drill_twin.scene.overrides import SHORTHANDS, full_key
from drill_twin.scene.schema import number_at

Block = Mapping[str, Any]
"""Block of a scene: keys as in a scene file; values are text with a unit (`"40 N"`) or numbers in SI."""
Overrides = Mapping[str, float | str]
"""Keys with dots, such as `rig.rotation.value`, and values: text with a unit, or numbers in SI. `wob` [N],
`rpm` [rev/min], `duration` [s] and `accuracy` are short for the keys most often set; `{"effects.bow": "off"}` takes an
effect out."""


def load_scene(scene: str | Path, overrides: Overrides | None = None, **named: float | str) -> Scene:
    """Load a scene from a file, or by the name of an installed one (`scene_names`).

    >>> scene = load_scene("pa6_bench", wob="60 N", rpm=120)
    >>> scene = load_scene("pa6_bench", {"effects.bow": "off", "hole.radius": "90 mm"})

    Args:
        scene: Name or file.
        overrides: Values that replace the file's values.
        named: The same, for keys without a dot: `wob`, `rpm`, `duration`, `accuracy`, `units`.

    Raises:
        SceneError: No such file, or not a scene; the message names file, line, key, expected and found.
    """
    return as_scene(load.load_scene(scene), {**(overrides or {}), **named})


def build_scene(
    name: str,
    *,
    base: str | Path | None = None,
    description: str = "",
    string: Block | None = None,
    hole: Block | None = None,
    rig: Block | None = None,
    effects: Mapping[str, Block | bool] | None = None,
    numerics: Block | None = None,
) -> Scene:
    """Build a scene; the blocks have the keys of a scene file.

    >>> scene = build_scene(
    ...     "rod",
    ...     string={"sections": [{"length": "5 m", "outer_diameter": "16.5 mm", "youngs_modulus": 2.3e9,
    ...                           "poisson_ratio": 0.394, "density": 1100.0}],
    ...             "marks": [{"name": "middle", "distance_from_bit": 2.5}]},
    ...     hole={"radius": "90 mm"},
    ...     rig={"weight_on_bit": {"value": "40 N"}, "rotation": {"value": "120 rpm"}, "duration": "10 s"},
    ...     effects={"gravity": True, "stretch": True, "torsion": True, "wall": {"stiffness": 1e7, "restitution": 0.5}},
    ... )

    Args:
        name: Short name.
        base: Installed scene or file from which all is taken that is not given.
        description: Purpose of the scene.
        string: Sections from the bit up, marks, and how the bit is held.
        hole: Radius, inclination or survey.
        rig: Set-points over time, top drive, duration.
        effects: By key: a block, True for the defaults of the effect, False for none.
        numerics: Resolution.

    Raises:
        SceneError: A block is missing or wrong; the message names key, expected and found.
    """
    blocks = {"base": None if base is None else str(base), "description": description, "string": string,
              "hole": hole, "rig": rig, "effects": effects, "numerics": numerics}  # fmt: skip
    return load.build_scene({"name": name, **{key: block for key, block in blocks.items() if block}}, name=name)


def check_scene(scene: Scene | str | Path, overrides: Overrides | None = None) -> Sequence[str]:
    """Problems of a scene as sentences; empty for a scene that can be run.

    Looks at what loading does not: the record that the scene plays.
    """
    from drill_twin.scene.set_points import Schedule

    try:
        Schedule.from_scene(as_scene(scene, overrides))
    except DrillTwinError as error:
        return [str(error)]
    return []


def write_scene(scene: Scene, path: str | Path) -> Path:
    """Write a scene to a new YAML file, units and defaults written out; `load_scene` reads it to an equal scene.

    Returns:
        The file.

    Raises:
        SceneError: The file exists or cannot be written.
    """
    file = Path(path)
    if file.exists():
        raise SceneError(f"{file}: expected a new file, found an existing file; choose another or remove it")
    with writing(file, "the scene", "choose another place", SceneError):
        write_whole(file, scene.to_yaml())
    return file


def scene_names() -> list[str]:
    """Names of the installed scenes, sorted."""
    return list(presets())


def as_scene(scene: Scene | str | Path, overrides: Overrides | None = None) -> Scene:
    """The scene itself, or the scene of a name or file, with its overrides applied."""
    if not isinstance(scene, Scene):
        return load_scene(scene, overrides)
    return override(scene, overrides) if overrides else scene


def with_resolution(scene: Scene) -> Scene:
    """The scene with elements and step in place of an accuracy."""
    if scene.numerics.accuracy is None:
        return scene
    from drill_twin.studies.accuracy import resolve

    return resolve(scene).scene


RPM = math.tau / 60.0
"""SI value of a revolution per minute [rad/s]."""
Quantity = float | str
"""Number in the documented unit, or text with its unit, such as `"40 N"`; a time without one is in s."""


def in_si(name: str, value: Quantity, dimension: Dimension, unit: float = 1.0) -> float:
    """SI value of an argument.

    Args:
        name: Name of the argument, for the message.
        value: The argument.
        dimension: Dimension of the argument.
        unit: SI value of the unit that a number is in.

    Raises:
        ArgumentError: Not a finite number, or text that is no quantity of the dimension.
    """
    if isinstance(value, str):
        try:
            bare = dimension == TIME and not split(value, dimension)[1]
            return parse(f"{value} s" if bare else value, dimension)
        except UnitError as error:
            raise ArgumentError(f"{name}: {error}") from None
    try:
        number = float(value) * unit
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise ArgumentError(f"{name}: expected {dimension.expected} or a finite number, found {value!r}")
    return number


def points_of(name: str, given: ArrayLike | str, dimension: Dimension, number: int) -> Array:
    """Rising numbers in SI, shape (p,): an array of them, or a range as text with its unit, such as "60..390 rpm".

    Args:
        name: Name of the argument, for the message.
        given: Numbers in SI, or a range; "60..390:30 rpm" has 30 points.
        dimension: Dimension of the argument.
        number: Points of a range that does not say.

    Raises:
        ArgumentError: The text is no range, or of another dimension, or the numbers do not rise.
    """
    if isinstance(given, str):
        span = parse_range(name, given)
        return np.array([in_si(name, f"{value!r} {span.unit}".strip(), dimension) for value in span.points(number)])
    if np.any(np.diff(found := np.atleast_1d(np.asarray(given, float))) <= 0.0):
        raise ArgumentError(f"{name}: expected increasing values, found {found.tolist()!s:.60}; sort them")
    return found


GivenRange = str | tuple[float, float]
"""Range: text such as "0.05..0.5" or "1..300 N", or both ends in SI."""


def range_of(
    scene: Scene, key: str, given: GivenRange, beside: Mapping[str, GivenRange] | None = None
) -> tuple[float, float]:
    """Ends of a range of a number of a scene, in SI, read as the scene reads the number.

    Args:
        scene: The scene.
        key: Key of the number, or a short name, such as `wob` [N] or `rpm` [rev/min].
        given: The range.
        beside: Ranges of numbers that vary with it, by key; the scene may take an end beside some of their ends only.

    Raises:
        ArgumentError: The text is no range, or the key names no number.
        SceneError: An end does not fit the scene, beside no ends of the others.
    """
    place = full_key(key, scene)
    others = [_ends(scene, *item) for item in (beside or {}).items() if item[0] != key]
    values = []
    for end in _ends(scene, key, given):
        beside_it = ({name: at for part in (end, *corner) for name, at in part.items()} for corner in product(*others))
        fitting = next((one for one in (end, *beside_it) if takes(scene, one)), end)
        values.append(number_at(override(scene, fitting), place))
    low, high = values
    if low is None or high is None:
        raise ArgumentError(f"{key}: expected the key of a number of {scene.name}, found {place}")
    if not low <= high:
        raise ArgumentError(f"{key}: expected a lower and a higher number, found {given!r}")
    return low, high


def takes(scene: Scene, overrides: Overrides) -> bool:
    """True if a scene takes these values together."""
    with suppress(SceneError):
        override(scene, overrides)
        return True
    return False


def which_fit(scene: Scene, draws: Iterable[Overrides]) -> list[bool]:
    """Mask of the draws of numbers that a scene takes together.

    Raises:
        ArgumentError: It takes none.
    """
    found = [takes(scene, one) for one in draws]
    if not any(found):
        raise ArgumentError(f"ranges: expected numbers that fit together, found none in {len(found)} draws")
    return found


def _ends(scene: Scene, key: str, given: GivenRange) -> list[Overrides]:
    """Both ends of a range as overrides."""
    place = key if isinstance(given, str) and key in SHORTHANDS else full_key(key, scene)
    return [{place: end} for end in (parse_range(key, given).ends if isinstance(given, str) else given)]
