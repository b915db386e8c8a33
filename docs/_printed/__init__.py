# SPDX-License-Identifier: Apache-2.0
"""Parts of pages that are printed from the code or the evidence, as Markdown by name.

A page takes one with a line of its own, `<!-- printed: NAME -->`. Where `<!-- end: NAME -->` follows, the text between
is committed: `docs/print_reference.py` writes it, and `test/documentation/test_reference.py` compares. Without an end,
`docs/conf.py` replaces the line while the site is built.
"""

from collections.abc import Callable

from _printed.api import api, api_names, summary_keys
from _printed.command_line import commands
from _printed.evidence import exact_checks, hard_scenes
from _printed.licences import licences
from _printed.nodes import nodes
from _printed.scene import effect_keys, scene_keys
from _printed.signals import signals
from _printed.topics import topics, topics_quality

PAGES: dict[str, Callable[[], str]] = {
    "api": api,
    "api_names": api_names,
    "commands": commands,
    "effect_keys": effect_keys,
    "exact_checks": exact_checks,
    "hard_scenes": hard_scenes,
    "licences": licences,
    "nodes": nodes,
    "scene_keys": scene_keys,
    "signals": signals,
    "summary_keys": summary_keys,
    "topics": topics,
    "topics_quality": topics_quality,
}
"""Function that prints each part."""
