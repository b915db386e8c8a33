# SPDX-License-Identifier: Apache-2.0
"""Scene of a node, from its parameters: name or path, and overrides."""

from collections.abc import Callable, Iterable
from types import SimpleNamespace

from drill_twin.core.errors import ParameterError
from drill_twin.ros.core.parameters import Parameter
from drill_twin.scene import Scene, load_scene

SCENE = Parameter("scene", "pa6_bench", "scene: an installed one by name, or the path of a scene file")
_LINE_PERIOD = 10.0  # s between two lines of progress
OVERRIDES = Parameter(
    "overrides",
    (),
    "changes to the scene as KEY=VALUE",
    such_as='["hole.radius=80 mm", "effects.bow=off"]',
    between=";",
)


def scene_of(settings: SimpleNamespace) -> Scene:
    """Scene of the parameters scene, overrides and, where a node has them, wob, rpm, accuracy, table.

    Raises:
        SceneError: The scene cannot be loaded.
        ParameterError: The overrides are not pairs KEY=VALUE.
    """
    changes = pairs_of("overrides", settings.overrides)
    for key in ("wob", "rpm", "accuracy"):
        if value := getattr(settings, key, ""):
            changes[key] = value
    if table := getattr(settings, "table", ""):
        changes |= _playing(load_scene(settings.scene, overrides=changes), table)
    return load_scene(settings.scene, overrides=changes)


def resolved(scene: Scene, duration: float, log: Callable[[str], object]) -> Scene:
    """Scene with elements and step chosen for its accuracy, where it has one; reports the expected error.

    Args:
        scene: The scene.
        duration: Simulated time of the run [s]; 0: the scene's.
        log: Called with a line of text.

    Raises:
        SceneError: The accuracy cannot be reached.
    """
    if scene.numerics.accuracy is None:
        return scene
    from drill_twin.studies.accuracy import resolve
    from drill_twin.studies.accuracy.measure import in_words

    plan = resolve(scene, duration=duration or None, progress=in_words(log, every=_LINE_PERIOD))
    log(plan.sentence)
    return plan.scene


def pairs_of(parameter: str, items: Iterable[str]) -> dict[str, str]:
    """Pairs of a list of texts `KEY=VALUE`.

    Raises:
        ParameterError: A text is no such pair.
    """
    pairs = {}
    for item in items:
        key, _, value = (word.strip() for word in item.partition("="))
        if not (key and value):
            raise ParameterError(f'parameter {parameter}: expected ["KEY=VALUE", "KEY=VALUE"], found "{item}"')
        pairs[key] = value
    return pairs


def _playing(scene: Scene, table: str) -> dict[str, str]:
    """Overrides that make a scene play a table: both set-points are taken from it, unless the scene names one."""
    changes = {"rig.table.file": table}
    rig = scene.rig
    if "table" not in {rig.weight_on_bit.shape, rig.rotation.shape}:
        changes["rig.weight_on_bit"] = f"{{shape: table, at: {rig.weight_on_bit.at}}}"
        changes["rig.rotation"] = "{shape: table}"
    return changes
