# SPDX-License-Identifier: Apache-2.0
"""Texts on `/twin/scene`, each parsed once: a latched message comes again to who reads it anew."""

from __future__ import annotations

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.topics import TWIN_SCENE
from drill_twin.scene import Scene, parse_scene


class SceneTexts:
    """Parses the texts that differ from the last good, and from the last bad one."""

    def __init__(self) -> None:
        self._text: str | None = None
        self._refused: tuple[str, DrillTwinError] | None = None

    def take(self, text: str) -> Scene | None:
        """Scene of a text; None for the last good one once more.

        Raises:
            DrillTwinError: It is no scene.
        """
        if text == self._text:
            return None
        if self._refused is not None and text == self._refused[0]:
            raise self._refused[1]
        try:
            scene = parse_scene(text, name=TWIN_SCENE)
        except DrillTwinError as error:
            self._refused = text, error
            raise
        self._text = text
        return scene
