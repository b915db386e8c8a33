# SPDX-License-Identifier: Apache-2.0
"""Truncated files and flipped bits: bags, metadata and checkpoints, each read or refused in a sentence.

60 inputs here, 12 000 with `make fuzz` (DRILL_TWIN_DAMAGE says how many; one in six is a truncation). A seed and a
number make each input again.
"""

import json
import os
import resource
import shutil
import sqlite3
import sys
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from companion_parts import part

sys.path.insert(0, str(Path(__file__).parent))

from limited import MEMORY, SECONDS
from summaries import summarise

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.report.recording import read_recording
from drill_twin.runs import Session
from drill_twin.scene import load_scene

PLAYER = part("drill_twin_dashboard.live.player")

SEED = 20261122
COUNT = int(os.environ.get("DRILL_TWIN_DAMAGE", "60"))
TRUNCATIONS = 6  # one in so many inputs
FILES = ("bag", "metadata", "checkpoint", "sqlite bag")


@dataclass
class Row:
    """What came of the inputs of one kind."""

    read: int = 0
    refused: int = 0
    slowest: float = 0.0
    largest: float = 0.0


@pytest.fixture(scope="module")
def material(bench_scene, tmp_path_factory):
    """A good folder with a bag in it and a good checkpoint."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    folder = tmp_path_factory.mktemp("good")
    scene = load_scene("pa6_bench", overrides={"duration": "0.1", "numerics.elements": "8"})
    bag = Bag(Session(scene).run(folder / "bag_0").bag)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(folder / "sql_0", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            name: writer.add_connection(name, topic.type_name, typestore=store) for name, topic in bag.topics.items()
        }
        for name, stamp, raw in bag.messages():
            writer.write(connections[name], stamp, raw)
    base = next((folder / "sql_0").glob("*.db3"))
    assert sqlite3.connect(base).execute("select count(*) from messages").fetchone()[0] > 50
    Checkpoint.of(Twin(bench_scene), Session(bench_scene).schedule.at(0.0)).save(folder / "run.npz")
    return folder


def attempt(kind, material, place, random, *, truncate):
    """Damage a copy of a file and read it as the commands do."""
    if kind == "checkpoint":
        shutil.copy(material / "run.npz", place / "run.npz")
        damage(place / "run.npz", random, truncate=truncate)
        Checkpoint.load(place / "run.npz").twin()
        return
    name = "sql_0" if kind == "sqlite bag" else "bag_0"
    pattern = {"bag": "*.mcap", "sqlite bag": "*.db3", "metadata": "metadata.yaml"}[kind]
    shutil.copytree(material / name, place / name)
    damage(next((place / name).glob(pattern)), random, truncate=truncate)
    json.dumps(summarise(read_recording(place / name)), allow_nan=False)
    if PLAYER:
        PLAYER.Player(place / name).close()


def damage(path, random, *, truncate):
    """Cut the end off, or flip one to eight bits."""
    data = bytearray(path.read_bytes())
    if truncate:
        del data[int(random.integers(len(data))) :]
    else:
        for place in random.integers(len(data), size=int(random.integers(1, 9))):
            data[place] ^= 1 << int(random.integers(8))
    path.write_bytes(data)


@pytest.mark.timeout(7200)
def test_truncations_and_flips_are_read_or_refused_in_a_sentence(material, tmp_path):
    rows, failures = defaultdict(Row), []
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(COUNT):
        truncate, kind = number % TRUNCATIONS == 0, FILES[number // TRUNCATIONS % len(FILES)]
        row = rows[kind, "cut" if truncate else "flipped"]
        place = tmp_path / "now"
        place.mkdir()
        begun = time.process_time()
        try:
            attempt(kind, material, place, np.random.default_rng((SEED, number)), truncate=truncate)
            row.read += 1
        except DrillTwinError as error:
            row.refused += 1
            text = str(error)
            if not text.strip() or "\n" in text or len(text) > 2000:
                failures.append(f"input {number} ({kind}): no sentence: {text[:200]!r}")
        except Exception as error:  # noqa: BLE001 - whatever it is, it must not reach a user
            failures.append(f"input {number} ({kind}): {type(error).__name__}: {str(error)[:200]}")
        row.slowest = max(row.slowest, time.process_time() - begun)
        row.largest = max(row.largest, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
        if row.slowest > SECONDS or row.largest > MEMORY:
            failures.append(f"input {number} ({kind}): {row.slowest:.1f} s, {row.largest:.0f} MB")
        shutil.rmtree(place)
    print(f"\n{COUNT} inputs, seed {SEED}\n| file | damage | inputs | read | refused | slowest [s] | memory [MB] |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for (kind, how), row in sorted(rows.items()):
        print(
            f"| {kind} | {how} | {row.read + row.refused} | {row.read} | {row.refused} | {row.slowest:.2f} "
            f"| {row.largest:.0f} |"
        )
    assert not failures, f"{len(failures)} failures:\n" + "\n".join(failures[:40])
    assert sum(row.refused for row in rows.values()) > COUNT // 10  # the damage is real
