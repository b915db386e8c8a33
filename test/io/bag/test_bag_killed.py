# SPDX-License-Identifier: Apache-2.0
"""Bags of killed writers (kill -9 of a real process), truncated and damaged bags can be read."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.reading.mcap_file import McapFile
from drill_twin.io.bag.series import PoseSeries
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.topics import STRING_POSES

RECORDER = """
import sys, time
import numpy as np
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.cdr import PoseArrayTemplate

poses, begin = PoseArrayTemplate(2), time.monotonic()  # so small that no chunk is ever full
writer = BagWriter(sys.argv[1], longest=float(sys.argv[2]))
for k in range(100_000):
    time.sleep(max(0.0, begin + 0.005 * k - time.monotonic()))
    stamp = int((time.monotonic() - begin) * 1e9)
    writer.write("/string/poses", stamp, poses.fill(stamp, np.full((2, 3), k), np.zeros((2, 4))))
    print(k, stamp, flush=True)
"""


@pytest.fixture(params=[0.0, 0.3], ids=["one_file", "split"])
def killed(tmp_path, request):
    """A bag whose writer was killed with signal 9 while it wrote 200 messages a second, and its last one."""
    command = [sys.executable, "-c", RECORDER, tmp_path / "run_0", str(request.param)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    lines = [process.stdout.readline()]
    begin = time.monotonic()
    while time.monotonic() - begin < 1.6:
        lines.append(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    lines += process.stdout.readlines()
    assert process.wait() == -signal.SIGKILL
    number, stamp = (int(word) for word in lines[-1].split())
    return tmp_path / "run_0", number, stamp


def test_kill_9_loses_at_most_the_last_fifth_of_a_second(killed):
    folder, number, stamp = killed
    assert not (folder / "metadata.yaml").exists()
    bag = Bag(folder)
    assert bag.truncated
    poses = PoseSeries()
    for _, _, raw in bag.messages((STRING_POSES,)):
        poses.add_message(raw)
    numbers = poses.position[:, 0, 0]
    np.testing.assert_array_equal(numbers, np.arange(numbers.size))  # nothing missing in between
    assert number > 200
    assert len(list(folder.iterdir())) == 1 or stamp > 0.3e9 * (len(list(folder.iterdir())) - 1) > 0.9e9
    assert stamp - poses.stamp[-1] < 0.2e9


def test_what_is_flushed_is_safe_while_the_writer_lives(tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0", flush_interval=1e9)
    for row in messages:
        writer.write(*row)
    with pytest.raises(BagError, match="found none"):
        Bag(writer.folder)
    writer.flush()
    assert list(Bag(writer.folder).messages()) == messages
    writer.close()


def test_an_idle_loop_flushes_when_due(tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0", flush_interval=0.05)
    writer.write(*messages[0])
    writer.flush_if_due()
    time.sleep(0.06)
    writer.flush_if_due()
    assert list(Bag(writer.folder).messages()) == messages[:1]
    writer.close()


def test_a_bag_cut_anywhere_keeps_what_is_before_the_cut(write_bag, messages, tmp_path):
    rows = messages[:30]
    content = (write_bag(rows=rows, flush_interval=0.0) / "run_0.mcap").read_bytes()
    cut, found = tmp_path / "cut.mcap", -1
    for size in [*range(0, len(content), 223), len(content)]:
        cut.write_bytes(content[:size])
        try:
            bag = Bag(cut)
        except BagError:
            assert found == -1  # only before the first message
            continue
        kept = list(bag.messages())
        assert kept == rows[: len(kept)]
        assert len(kept) >= found
        assert bag.message_count == len(kept)
        assert bag.truncated == (size < len(content))
        found = len(kept)
    assert found == len(rows)


@pytest.mark.parametrize("seed", range(5))
def test_damage_anywhere_never_yields_a_wrong_message(write_bag, messages, tmp_path, seed):
    rows = messages[:30]
    whole = (write_bag(rows=rows, flush_interval=0.0) / "run_0.mcap").read_bytes()
    originals, random = set(rows), np.random.default_rng(seed)
    damaged, opened = tmp_path / "damaged.mcap", 0
    for _ in range(100):
        content = bytearray(whole)
        for place in random.integers(len(content), size=random.integers(1, 4)):
            content[place : place + random.integers(9)] = random.bytes(random.integers(9))
        damaged.write_bytes(bytes(content))
        try:
            bag = Bag(damaged)
        except BagError:
            continue
        opened += 1
        assert all(row in originals for row in bag.messages())
    assert opened > 20


def test_a_damaged_chunk_is_left_out_and_said(write_bag, messages, tmp_path):
    file = write_bag(flush_interval=0.0) / "run_0.mcap"
    content = file.read_bytes()
    places = [k for k in range(len(content) // 3, len(content)) if content[k : k + 4] == b"zstd"]
    changed = bytearray(content)
    changed[places[5] + 30] ^= 0xFF
    file.write_bytes(bytes(changed))
    bag = Bag(file)
    assert len(bag.damage) == 1
    assert "damaged chunk" in bag.damage[0]
    found = list(bag.messages())
    assert len(found) == len(messages) - 1


def test_messages_of_topics_whose_names_are_lost_are_said(write_bag):
    """All topics are announced in the first chunk; without it the rest has no names."""
    file = write_bag(flush_interval=0.0) / "run_0.mcap"
    content = bytearray(file.read_bytes())
    content[content.index(b"zstd") + 40] ^= 0xFF
    file.write_bytes(bytes(content))
    contents = McapFile(file)
    assert any("names were lost" in text for text in contents.damage)
