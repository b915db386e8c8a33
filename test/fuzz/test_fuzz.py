# SPDX-License-Identifier: Apache-2.0
"""Damaged scenes, tables, bags and checkpoints: read, or refused in one line, soon and without taking much memory.

300 inputs here, 10 000 with `make fuzz` (DRILL_TWIN_FUZZ says how many). A seed and a number make each input again.
"""

import json
import os
import resource
import shutil
import signal
import sqlite3
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from companion_parts import part
from scipy.io import savemat

sys.path.insert(0, str(Path(__file__).parent))

from mutate import mutated

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.runs import Session
from drill_twin.scene import load_scene
from drill_twin.scene.paths import config_dir
from drill_twin.scene.set_points.tables import read_table

PAGE = part("drill_twin_dashboard.live.page_state")

SEED = 20261121
COUNT = int(os.environ.get("DRILL_TWIN_FUZZ", "150"))
SLOW = 5  # s of processor time, children included: how busy the machine is is not the input's doing
HANGS = 60  # s
MUCH = 300 * 1024  # kB
RECORDS = ("csv", "las", "xml")
KINDS = (*(("scene", *RECORDS, "mcap", "metadata", "sqlite3", "message", "checkpoint") * 6), "mat")
LAS = """~Version
VERS. 2.0 : CWLS LOG ASCII STANDARD - VERSION 2.0
WRAP.  NO : ONE LINE PER STEP
~Well
NULL. -999.25 : NULL
~Curve
TIME.S   : time
WOB .KN  : weight on bit
RPM .RPM : rotary speed
NOTE.    : remark
~Ascii
"""
WITSML = """<?xml version="1.0" encoding="UTF-8"?>
<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log uidWell="w" uidWellbore="b" uid="l">
<indexType>date time</indexType><indexCurve>Time</indexCurve><nullValue>-999.25</nullValue>
<logData><mnemonicList>Time,WOB,RPM,NOTE</mnemonicList><unitList>unitless,N,c/s,unitless</unitList>
"""


@pytest.fixture(scope="module")
def material(bench_scene, tmp_path_factory):
    """What is damaged: a good file of each kind."""
    folder = tmp_path_factory.mktemp("good")

    bag = (
        Session(load_scene("pa6_bench", overrides={"duration": "0.1", "numerics.elements": "8"}))
        .run(folder / "bag_0")
        .bag
    )
    time = np.arange(0.0, 2.0, 0.02)
    rows = [f"{t:.2f},{20.0 + t},{60.0 + 5.0 * t}" for t in time]
    (folder / "table.csv").write_text("time (s),WOB (N),rpm\n" + "\n".join(rows) + "\n", "utf-8")
    (folder / "table.las").write_text(LAS + "".join(f"{t:.2f} {20.0 + t} -999.25 drilling\n" for t in time), "utf-8")
    stamps = [f"<data>2016-09-30T10:04:{t:06.3f}Z,{20.0 + t},1,on bottom</data>" for t in time]
    (folder / "table.xml").write_text(WITSML + "\n".join(stamps) + "</logData></log></logs>\n", "utf-8")
    savemat(folder / "table.mat", {"time": time, "wob": 20.0 + time, "rpm": 60.0 + time})
    twin = Twin(bench_scene)
    Checkpoint.of(twin, Session(bench_scene).schedule.at(0.0)).save(folder / "run.npz")
    _as_sqlite3(bag, folder / "sql_0")
    return folder, bag


def _as_sqlite3(bag, target):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, good = get_typestore(Stores.ROS2_JAZZY), Bag(bag)
    with Writer(target, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            name: writer.add_connection(name, topic.type_name, typestore=store) for name, topic in good.topics.items()
        }
        for name, stamp, raw in good.messages():
            writer.write(connections[name], stamp, raw)
    assert sqlite3.connect(next(target.glob("*.db3"))).execute("select count(*) from messages").fetchone()[0] > 50


def _read_bag(path):
    """As the command line does: all messages, the analysis, the page."""
    pipeline, page = WhirlPipeline(), PAGE.PageState() if PAGE else None
    for topic, _, raw in Bag(path).messages():
        pipeline.analyse(topic, raw)
        if page and topic in PAGE.INPUTS:
            page.update(topic, raw)
    json.dumps(page and page.snapshot(), allow_nan=False)


def _damage_file(source, target, random, *, text):
    target.write_bytes(mutated(source.read_bytes(), random, text=text))


def _damage_in_bag(source, target, name, random, *, text):
    shutil.copytree(source, target)
    file = next(target.glob(name))
    file.write_bytes(mutated(file.read_bytes(), random, text=text))


def _attempt(kind, material, place, random):
    """Damage a copy and read it."""
    folder, bag = material
    if kind == "scene":
        source = sorted((config_dir() / "scenes").glob("*.yaml"))[int(random.integers(3))]
        _damage_file(source, place / "scene.yaml", random, text=True)
        load_scene(place / "scene.yaml").to_yaml()
    elif kind in {*RECORDS, "mat"}:
        _damage_file(folder / f"table.{kind}", place / f"table.{kind}", random, text=kind != "mat")
        with suppress(DrillTwinError):
            RecordBag(place / f"table.{kind}")
        read_table(place / f"table.{kind}")
    elif kind == "mcap":
        _damage_in_bag(bag, place / "bag_0", "*.mcap", random, text=False)
        _read_bag(place / "bag_0")
    elif kind == "metadata":
        _damage_in_bag(bag, place / "bag_0", "metadata.yaml", random, text=True)
        _read_bag(place / "bag_0")
    elif kind == "sqlite3":
        _damage_in_bag(
            folder / "sql_0", place / "sql_0", ("*.db3", "metadata.yaml")[int(random.integers(2))], random, text=False
        )
        _read_bag(place / "sql_0")
    elif kind == "checkpoint":
        _damage_file(folder / "run.npz", place / "run.npz", random, text=False)
        Checkpoint.load(place / "run.npz")
    else:
        pipeline, page = WhirlPipeline(), PAGE.PageState() if PAGE else None
        for topic, _, raw in Bag(bag).messages():
            sent = mutated(raw, random, text=False) if random.random() < 0.2 else raw
            pipeline.analyse(topic, sent)
            if page:
                page.update(topic, sent)
        json.dumps(page and page.snapshot(), allow_nan=False)


def _processor_time():
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


@pytest.mark.timeout(7200)
def test_damaged_input_is_read_or_refused_in_one_line(material, tmp_path):
    def too_slow(number, frame):
        raise TimeoutError

    failures: list[str] = []
    before, refused, slowest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, 0, 0.0
    handler = signal.signal(signal.SIGALRM, too_slow)
    try:
        for number in range(COUNT):
            kind, random = KINDS[number % len(KINDS)], np.random.default_rng((SEED, number))
            place = tmp_path / "now"
            place.mkdir()
            begun = _processor_time()
            signal.alarm(HANGS)
            try:
                _attempt(kind, material, place, random)
            except DrillTwinError as error:
                refused += 1
                text = str(error)
                if not text.strip() or "\n" in text or len(text) > 2000:
                    failures.append(f"input {number} ({kind}): no error of one line: {text[:200]!r}")
            except Exception as error:  # noqa: BLE001 - whatever it is, it must not reach a user
                failures.append(f"input {number} ({kind}): {type(error).__name__}: {str(error)[:200]}")
            finally:
                signal.alarm(0)
            took = _processor_time() - begun
            slowest = max(slowest, took)
            if took > SLOW:
                failures.append(f"input {number} ({kind}): {took:.1f} s")
            shutil.rmtree(place)
            grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
            assert grown < MUCH, (kind, number, grown)
    finally:
        signal.signal(signal.SIGALRM, handler)
    print(f"{COUNT} damaged inputs: {refused} refused in one line, {COUNT - refused} read; slowest {slowest:.2f} s")
    assert not failures, f"seed {SEED}, {len(failures)} failures:\n" + "\n".join(failures[:40])
    assert refused > COUNT // 4  # the damage is real
