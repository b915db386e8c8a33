# SPDX-License-Identifier: Apache-2.0
"""Mend a bag whose writer was killed: all that can be read, in a new, finished bag."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter


def recover(path: str | Path, folder: str | Path | None = None) -> Path:
    """Copy all whole chunks of a bag, truncated or not, to a new bag with index and `metadata.yaml`.

    Args:
        path: Bag folder or file.
        folder: New folder; by default `run_recovered_0` next to a bag `run_0`.

    Returns:
        The new folder.

    Raises:
        BagError: There is nothing to recover, or the new folder exists or cannot be written.
    """
    bag = Bag(path)
    target = _beside(bag.path) if folder is None else Path(folder)
    topics = [replace(topic, count=0) for topic in bag.topics.values()]
    custom = {"recovered_from": bag.path.name, **({"damage": "; ".join(bag.damage)} if bag.damage else {})}
    with BagWriter(target, topics=topics, custom_data=custom) as writer:
        for name, stamp, raw in bag.messages():
            writer.write(name, stamp, raw)
    return target


def _beside(path: Path) -> Path:
    folder = path if path.is_dir() else path.parent
    stem = re.sub(r"_\d+$", "", folder.resolve().name)
    return folder.resolve().with_name(f"{stem}_recovered_0")
