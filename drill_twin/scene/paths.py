# SPDX-License-Identifier: Apache-2.0
"""Paths of the installed scenes, launch files and views."""

import site
import sys
from pathlib import Path

from drill_twin.core.companions import entry_of
from drill_twin.core.errors import SceneError, nearest

GROUP = "drill_twin.scenes"
"""Entry-point group of folders of scenes in other packages."""
_MARK = Path("scenes") / "pa6_bench.yaml"
_SUFFIXES = (".yaml", ".yml")


def config_dir() -> Path:
    """The folder with `scenes/` in it: beside the package in a source tree, else in the ROS or Python installation.

    Raises:
        SceneError: The package was installed without its data.
    """
    folders = list(_candidates())
    for folder in folders:
        if (folder / _MARK).is_file():
            return folder
    looked = ", ".join(str(folder) for folder in folders)
    raise SceneError(f"expected the installed scenes of drill_twin, found none in {looked}; reinstall the package")


def presets() -> dict[str, Path]:
    """Names of the installed scenes and their files, sorted."""
    return {path.stem: path for path in sorted((config_dir() / "scenes").glob("*.yaml"))}


def well_scenes() -> dict[str, Path]:
    """Names (`wells/...`) and files, sorted, of the scenes of wells."""
    return {f"wells/{path.stem}": path for path in sorted((config_dir() / "wells").glob("*.yaml"))}


def added_scenes(folder: str) -> dict[str, Path]:
    """Names (`folder/...`) and files, sorted, of the scenes of another package.

    The package adds its scenes through the entry-point group ``drill_twin.scenes``: the entry's name is the first part
    of the scenes' names, its value a `Path` of their folder (``field = my_package:SCENES``).

    Args:
        folder: First part of the names.

    Returns:
        Nothing if no package has scenes of this folder.

    Raises:
        SceneError: The entry point cannot be loaded.
    """
    if entry := entry_of(GROUP, folder):
        try:
            place = Path(entry.load())
        except Exception as error:
            raise SceneError(
                f"{folder}/: expected the folder of scenes {entry.value} of another package, found "
                f"{type(error).__name__}: {error}; reinstall that package, or remove it"
            ) from error
        return {f"{folder}/{path.stem}": path for path in sorted(place.glob("*.yaml"))}
    return {}


def scene_path(scene: str | Path) -> Path:
    """File of a scene given by its path or by the name of an installed scene.

    Raises:
        SceneError: No such file; the installed scenes are listed.
    """
    path = Path(scene)
    try:
        if path.is_file():
            return path
    except OSError as error:
        raise SceneError(f"{str(scene)[:100]}: cannot be read: {error.strerror}") from None
    known = presets()
    for named in (known, well_scenes(), added_scenes(str(scene).partition("/")[0])):
        if str(scene) in named:
            return named[str(scene)]
    if path.is_dir():
        raise SceneError(f"{scene}: expected a scene file, found a folder")
    if path.exists():
        raise SceneError(f"{scene}: expected a scene file, found a pipe or a device")
    for suffix in _SUFFIXES:
        if path.name and path.suffix not in _SUFFIXES and path.with_name(path.name + suffix).is_file():
            return path.with_name(path.name + suffix)
    beside = [str(path.with_name(file.name)) for suffix in _SUFFIXES for file in sorted(path.parent.glob(f"*{suffix}"))]
    names = [*known, *well_scenes()]
    raise SceneError(
        f"{str(scene)[:200]}: no such scene file{nearest(str(scene)[:200], [*names, *beside])}; "
        f"expected a path or one of the installed scenes: {', '.join(names)}"
    )


def _candidates() -> "list[Path]":
    beside = Path(__file__).resolve().parents[2]
    roots = [beside / "share" / "drill_twin"]  # `pip install --target`
    try:
        from ament_index_python.packages import get_package_share_directory

        roots.append(Path(get_package_share_directory("drill_twin")))
    except (ImportError, LookupError, OSError):  # no ROS environment, or one without this package
        pass
    roots += [Path(prefix) / "share" / "drill_twin" for prefix in (sys.prefix, site.getuserbase())]
    return [beside / "config", *(folder for root in roots for folder in (root / "config", root))]
