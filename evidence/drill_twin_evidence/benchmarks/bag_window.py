# SPDX-License-Identifier: Apache-2.0
"""Cost of one minute out of a large bag, for MCAP and SQLite.

    python -m drill_twin_evidence.benchmarks.bag_window [GIGABYTES]

Two seconds of `pa6_bench` at 200 frames a second are repeated, with rising stamps, until the file has its size. Printed
are the wall and processor time of `drill-twin export BAG --csv --from A --to B`, its start included, and the bytes
that the reader took of the file, from the disk or from memory.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import drill_twin as dt
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.reading.bag_file import WITH_HEADER
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.stamps import NANOSECONDS, pack_stamp, raw_header_stamp
from drill_twin.io.messages.topics import TOPICS, TWIN_SCENE
from drill_twin.report.rig_table import read_rig
from drill_twin.report.selection import Selection
from drill_twin.runs import Session

_MINUTE, _RUN = 60.0, 2
_Message = tuple[str, int, bytes]


def main(gigabytes: float = 2.0) -> None:
    """Write the bags, read a minute of each, and print the result."""
    print("storage  size [GB]  length [min]  wall [s]  processor [s]  bytes read [MB]  share of the file")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = dt.load_scene("pa6_bench", {"numerics.frame_rate": "200 Hz", "rig.duration": f"{_RUN} s"})
        messages = list(Bag(Session(scene).run(folder / "run").bag).messages())
        for storage, write in (("mcap", _write_mcap), ("sqlite3", _write_sqlite)):
            bag = folder / storage
            length = write(bag, messages, gigabytes * 1e9)
            _measure(storage, bag, length)
            for file in bag.iterdir():
                file.unlink()


def _write_mcap(folder: Path, messages: list[_Message], size: float) -> float:
    with BagWriter(folder) as writer:
        for topic, stamp, raw in _repeated(messages):
            if topic == TWIN_SCENE and _size(folder) >= size:
                break
            if topic != TWIN_SCENE or not stamp:
                writer.write(topic, stamp, raw)
    return stamp / NANOSECONDS


def _write_sqlite(folder: Path, messages: list[_Message], size: float) -> float:
    store, written = get_typestore(Stores.ROS2_JAZZY), 0
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {
            name: writer.add_connection(name, TOPICS[name].type_name, typestore=store)
            for name in dict.fromkeys(topic for topic, _, _ in messages)
        }
        for topic, stamp, raw in _repeated(messages):
            if topic != TWIN_SCENE or not stamp:
                writer.write(topics[topic], stamp, raw)
                written += len(raw)
            if written >= size:
                break
    return stamp / NANOSECONDS


def _repeated(messages: list[_Message]) -> Iterator[_Message]:
    """The messages of a run again and again, each time stamped later, without end."""
    later = 0
    while True:
        for topic, stamp, raw in messages:
            message = bytearray(raw)
            if TOPICS[topic].type_name in WITH_HEADER:
                pack_stamp(message, 4, raw_header_stamp(raw) + later)
            yield topic, stamp + later, bytes(message)
        later += _RUN * NANOSECONDS + 5_000_000


def _measure(storage: str, bag: Path, length: float) -> None:
    begin = 0.7 * length
    given = ["export", str(bag), "--csv", "--out", str(bag.with_name("minute")), "--replace"]
    between = ["--from", f"{begin:g}", "--to", f"{begin + _MINUTE:g}"]
    words = [sys.executable, "-c", "from drill_twin.cli import main; main()", *given, *between]
    spent, began = _spent(), time.perf_counter()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wall, spent = time.perf_counter() - began, _spent() - spent
    before = _bytes_read()
    read_rig(bag, Selection(begin=begin, end=begin + _MINUTE))
    taken, size = _bytes_read() - before, _size(bag)
    print(
        f"{storage:7}  {size / 1e9:9.2f}  {length / 60:12.1f}  {wall:8.2f}  {spent:13.2f}  {taken / 1e6:15.1f}  "
        f"{taken / size:17.3f}",
        flush=True,
    )


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.iterdir())


def _spent() -> float:
    """Processor time of the children so far [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _bytes_read() -> int:
    """Bytes that this process has read so far."""
    return int(Path(f"/proc/{os.getpid()}/io").read_text().split()[1])


if __name__ == "__main__":
    main(*map(float, sys.argv[1:2]))
