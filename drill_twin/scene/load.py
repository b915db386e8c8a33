# SPDX-License-Identifier: Apache-2.0
"""Loading of scenes from files and texts; errors name file and line, and one check shows all problems."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from drill_twin.core.errors import SceneError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.yaml_reader import LARGEST_TEXT
from drill_twin.core.process import error_text
from drill_twin.core.units.system import typed_in_pounds
from drill_twin.physics.effects.config import refuse_all
from drill_twin.scene.blocks.effects import Effects
from drill_twin.scene.blocks.hole import Hole
from drill_twin.scene.blocks.rig import Rig
from drill_twin.scene.blocks.string import String
from drill_twin.scene.check import UnknownPart, contradictions
from drill_twin.scene.lines import Lines, copy_plain, read_lines
from drill_twin.scene.overrides import apply_overrides
from drill_twin.scene.paths import scene_path
from drill_twin.scene.problems import scene_error
from drill_twin.scene.schema import Scene

_FILE = ForeignFile("text", LARGEST_TEXT, SceneError)
_TABLE_FILE = ("rig", "table", "file")
_WEIGHT = ("rig", "weight_on_bit", "value")
DEEPEST_BASE = 8
"""Longest chain of scenes based on one another."""


def load_scene(scene: str | Path, *, overrides: Mapping[str, str] | None = None) -> Scene:
    """Load a scene from a file or by the name of an installed scene, such as `pa6_bench`.

    Overrides are dotted keys and values as in a file: `{"rig.rotation.value": "50 rpm"}`; `wob`, `rpm` and `duration`
    are short for the keys most often set, and `{"effects.bow": "off"}` removes an effect.

    A file with `base: pa6_bench` (a name, or a path from the file's folder) contains only the differences from that
    scene, lists in full; `value: ~` removes a key of the base.

    Raises:
        SceneError: No such file, not YAML, or not a scene; with file, line, key, expected and found.
    """
    path = scene_path(scene)
    return _build(read_lines(_FILE.text(path), str(path)), overrides, folder=path.parent)


def parse_scene(text: str, *, name: str = "scene", overrides: Mapping[str, str] | None = None) -> Scene:
    """Parse a scene from a YAML text such as that on `/twin/scene`; a `run` block is ignored.

    Raises:
        SceneError: As `load_scene`.
    """
    lines = read_lines(text, name)
    lines.data.pop("run", None)
    return _build(lines, overrides, folder=Path())


def build_scene(
    data: Mapping[str, Any], *, name: str = "scene", overrides: Mapping[str, float | str] | None = None
) -> Scene:
    """Build a scene from plain data with the keys of a scene file; numbers without a unit are in SI.

    Args:
        data: Blocks, lists and values; with `base`, only the differences from that scene.
        name: Name of the data in messages.
        overrides: As for `load_scene`; numbers in SI, under a short name in the unit of that name.

    Raises:
        SceneError: As `load_scene`.
    """
    return _build(Lines(name, copy_plain(data)), overrides, folder=Path(), text=False)


def override(scene: Scene, overrides: Mapping[str, float | str]) -> Scene:
    """Copy of a scene with other values.

    Raises:
        SceneError: An unknown key, or values that do not fit together.
    """
    return build_scene(scene.model_dump(mode="json", exclude_none=True), name=scene.name, overrides=overrides)


def _build(lines: Lines, overrides: Mapping[str, float | str] | None, *, folder: Path, text: bool = True) -> Scene:
    _inherit(lines, folder)
    apply_overrides(lines, overrides or {})
    _anchor_table(lines, folder)
    _keep_typed_units(lines)
    try:
        return Scene.model_validate(lines.data, context={"text": text})
    except ValidationError as error:
        found = [*error.errors(include_url=False), *contradictions_of_valid_parts(lines.data, text=text)]
        raise scene_error(found, lines, Scene) from None


def _inherit(lines: Lines, folder: Path, depth: int = 0) -> None:
    """Fill in the keys of the scene named as `base`."""
    if "base" not in lines.data:
        return
    name = lines.data.pop("base")
    place = lines.where(("base",))
    if not isinstance(name, str) or not name:
        raise SceneError(f"{place}: base: expected the name or the file of a scene, found {name!r}")
    if depth == DEEPEST_BASE:
        raise SceneError(f"{place}: base: expected at most {DEEPEST_BASE} scenes based on each other, found more")
    try:
        path = scene_path(folder / name if _is_file(folder / name) else name)
    except SceneError as error:
        raise SceneError(f"{place}: base: {error}") from None
    base = read_lines(_FILE.text(path), str(path))
    _inherit(base, path.parent, depth + 1)
    _anchor_table(base, path.parent)
    lines.inherit(base)


def _keep_typed_units(lines: Lines) -> None:
    """Show field units where the weight on bit is written in pounds, unless the file, or the override, says else."""
    rig = lines.data.get("rig")
    weight = rig.get("weight_on_bit") if isinstance(rig, dict) else None
    written = weight.get("value") if isinstance(weight, dict) else None
    decided = lines.overridden & {_WEIGHT, ("units",)}
    if typed_in_pounds(written) and (decided == {_WEIGHT} or lines.data.get("units", "auto") == "auto"):
        lines.data["units"] = "field"


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # too long, a loop
        return False


def _anchor_table(lines: Lines, folder: Path) -> None:
    """Make the table's path absolute: from the scene's folder, or for an override from the working folder."""
    rig = lines.data.get("rig")
    table = rig.get("table") if isinstance(rig, dict) else None
    file = table.get("file") if isinstance(table, dict) else None
    if isinstance(table, dict) and isinstance(file, str) and file:
        base = Path() if ("rig", "table", "file") in lines.overridden else folder
        try:
            table["file"] = str((base / Path(file).expanduser()).resolve())
        except (OSError, RuntimeError, ValueError) as error:  # a loop of links, ~nobody, NUL
            found = f"{file[:100]!r} ({error_text(error)[:200]})"
            raise SceneError(f"{lines.where(_TABLE_FILE)}: rig.table.file: expected a path, found {found}") from None


def contradictions_of_valid_parts(data: dict[str, Any], *, text: bool) -> list[ErrorDetails]:
    """Find the contradictions that an invalid part would hide, as pydantic checks a whole with valid parts only.

    Args:
        data: The scene's data.
        text: True if a number without a unit is invalid.
    """
    parts: dict[str, type[BaseModel]] = {"string": String, "hole": Hole, "rig": Rig}
    valid: dict[str, Any] = {key: _valid(kind, data.get(key), text) for key, kind in parts.items()}
    scene = Scene.model_construct(effects=_valid_effects(data.get("effects"), text), **valid)
    found = list(contradictions(scene))
    return refuse_all(found).errors(include_url=False) if found else []


def _valid(kind: type[BaseModel], data: Any, text: bool) -> Any:
    try:
        return kind.model_validate(data, context={"text": text})
    except ValidationError:
        return UnknownPart()


def _valid_effects(data: Any, text: bool) -> Any:
    """Effects of the valid blocks; an invalid block raises UnknownPartError when asked for."""
    if not isinstance(data, dict):
        return UnknownPart()
    known = {key: block for key, block in data.items() if key in Effects.model_fields}
    invalid = {key for key, block in known.items() if isinstance(_valid(Effects, {key: block}, text), UnknownPart)}
    valid = Effects.model_validate(
        {key: block for key, block in known.items() if key not in invalid}, context={"text": text}
    )
    return UnknownPart(valid, invalid)
