# SPDX-License-Identifier: Apache-2.0
"""Parts of the reference that are printed from the code while the site is built, as Markdown by name.

A page takes one with a line of its own, `<!-- printed: NAME -->`; `docs/conf.py` replaces it.
"""

from collections.abc import Callable

from _printed.api import api
from _printed.command_line import commands
from _printed.nodes import nodes
from _printed.scene import effect_keys, scene_keys
from _printed.topics import topics, topics_quality

PAGES: dict[str, Callable[[], str]] = {
    "api": api,
    "commands": commands,
    "effect_keys": effect_keys,
    "nodes": nodes,
    "scene_keys": scene_keys,
    "topics": topics,
    "topics_quality": topics_quality,
}
"""Function that prints each part."""
