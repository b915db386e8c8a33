# SPDX-License-Identifier: Apache-2.0
"""Hashes of every topic that runs of the shipped scenes publish, to see that a change of code changes no result.

    python test/regression/physics_hashes.py            # compare with physics_hashes.json
    python test/regression/physics_hashes.py --write    # after a change that is meant to alter results

Each scene of `config/scenes` runs for 10 s in each of its forms, in lockstep; a second run is put down in a checkpoint
half-way, taken up from the file and must publish the same. Machine code, and so the last bits, depend on the processor
and on the versions of numba and numpy; the file names those that it is for.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding
import numba
import numpy as np

from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE, REALTIME_FACTOR, RIG_STATE, STRING_POSES, TWIN_SCENE
from drill_twin.runner import Session
from drill_twin.scene import Scene, load_scene, presets
from drill_twin.schedule import Schedule
from drill_twin.twin.checkpoint import Checkpoint
from drill_twin.twin.twin import Twin

FILE = Path(__file__).with_suffix(".json")
DURATION = 10.0  # [s]
UNSTABLE = {TWIN_SCENE, DIAGNOSTICS, REALTIME_FACTOR}  # they tell wall time
COMPARED_WITH_RECORDS = {"ufrj_torsion", "well_b"}  # by `drill-twin validate`
SAME_MOTION = {"bha_stress"}  # as bha_full_size
LATERAL = {"effects.stretch": "off", "effects.torsion": "off"}


def record() -> Path | None:
    """The public record that `ufrj_rig` plays, where it is at hand."""
    named = os.environ.get("DRILL_TWIN_DATA")
    folders = [Path(named)] if named else [Path(__file__).resolve().parents[3] / "shared" / "data"]
    found = [path for folder in folders for path in folder.rglob("175_completo_1.mat")]
    return found[0] if found else None


def cases() -> dict[str, Scene]:
    """Scene and form -> the scene."""
    found = {}
    for name in sorted(set(presets()) - COMPARED_WITH_RECORDS - SAME_MOTION):
        changes = {"rig.duration": f"{DURATION} s"}
        if name == "ufrj_rig":
            if (table := record()) is None:
                continue
            changes["rig.table.file"] = str(table)
        scene = load_scene(name, overrides=changes)
        found[f"{name}/spatial"] = scene
        needing = [block for block in scene.effects.blocks.values() if {"stretch", "torsion"} & set(block.requires)]
        if not needing and scene.effects.stretch is not None:
            found[f"{name}/lateral"] = load_scene(name, overrides=changes | LATERAL)
    return found


def environment() -> dict[str, str]:
    """What the last bits depend on besides the code."""
    return {
        "processor": llvmlite.binding.get_host_cpu_name(),
        "features": hashlib.sha256(llvmlite.binding.get_host_cpu_features().flatten().encode()).hexdigest()[:16],
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": np.__version__,
    }


def hashes_of(scene: Scene) -> dict[str, str]:
    """Topic -> number of messages and hash of all of their stamps and bytes."""
    with tempfile.TemporaryDirectory() as folder:
        outcome = Session(scene).run(Path(folder) / "bag_0")
        found: dict[str, Any] = {}
        count: dict[str, int] = {}
        for topic, stamp, raw in Bag(outcome.bag).messages():
            if topic in UNSTABLE:
                continue
            digest = found.setdefault(topic, hashlib.sha256())
            digest.update(stamp.to_bytes(8, "little"))
            digest.update(raw)
            count[topic] = count.get(topic, 0) + 1
    return {topic: f"{count[topic]} {digest.hexdigest()[:32]}" for topic, digest in sorted(found.items())}


def hashes_with_checkpoint(scene: Scene) -> dict[str, str]:
    """The same for the physics topics of a run that is put down half-way and taken up from a file."""
    from drill_twin.io.messages.encode import TwinEncoder
    from drill_twin.io.scene_geometry import string_geometry
    from drill_twin.twin.frame import Frames

    schedule = Schedule.from_scene(scene)
    period = round(NANOSECONDS / scene.numerics.frame_rate)
    frames = round(DURATION * NANOSECONDS / period)
    twin = Twin(scene)
    encoder = TwinEncoder(string_geometry(twin))
    encoders = {RIG_STATE: encoder.rig_state, MARKS_STATE: encoder.marks, STRING_POSES: encoder.poses}
    digests = {topic: hashlib.sha256() for topic in encoders}
    for number in range(1, frames + 1):
        stamp = number * period
        command = schedule.at(seconds(stamp))
        frame = twin.advance(command, seconds(period))
        for topic, encode in encoders.items():
            digests[topic].update(stamp.to_bytes(8, "little"))
            digests[topic].update(encode(Frames.of(frame))[0])
        if number == frames // 2:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "checkpoint.npz"
                Checkpoint.of(twin, command).save(path)
                twin = Checkpoint.load(path).twin()
    return {topic: f"{frames} {digest.hexdigest()[:32]}" for topic, digest in digests.items()}


def differences(name: str, scene: Scene, expected: dict[str, str]) -> list[str]:
    """Topics that are not as they were, in words."""
    found = hashes_of(scene)
    told = [
        f"{name} {topic}: expected {expected.get(topic)}, found {found.get(topic)}"
        for topic in sorted({*expected, *found})
        if expected.get(topic) != found.get(topic)
    ]
    resumed = hashes_with_checkpoint(scene)
    return told + [
        f"{name} {topic}: a run taken up from a checkpoint differs from one that was not put down"
        for topic in resumed
        if resumed[topic] != found.get(topic)
    ]


def main() -> int:
    """Compare, or write."""
    if "--write" in sys.argv:
        kept = json.loads(FILE.read_text("utf-8"))["topics"]  # those of a record that is not at hand
        topics = kept | {name: hashes_of(scene) for name, scene in cases().items()}
        FILE.write_text(json.dumps({"environment": environment(), "topics": topics}, indent=1) + "\n", "utf-8")
        return 0
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")]
    content = json.loads(FILE.read_text("utf-8"))
    if content["environment"] != environment():
        print(f"hashes are of {content['environment']}, this is {environment()}")
    told: list[str] = []
    for name, scene in cases().items():
        if not wanted or any(word in name for word in wanted):
            found = differences(name, scene, content["topics"].get(name, {}))
            print(f"{name}: {'as before' if not found else 'CHANGED'}", flush=True)
            told += found
    print("\n".join(told))
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main())
