# SPDX-License-Identifier: Apache-2.0
"""Scenes: string, hole, rig, effects and numerics of a run, from YAML with units, validated as a whole."""

from drill_twin.scene.json_schema import scene_json_schema
from drill_twin.scene.load import load_scene, parse_scene
from drill_twin.scene.paths import added_scenes, config_dir, presets, scene_path, well_scenes
from drill_twin.scene.schema import MarkPlace, Scene

__all__ = [
    "MarkPlace", "Scene", "added_scenes", "config_dir", "load_scene", "parse_scene", "presets", "scene_json_schema",
    "scene_path", "well_scenes",
]  # fmt: skip
