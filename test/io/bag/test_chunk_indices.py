# SPDX-License-Identifier: Apache-2.0
"""Chunk indices of a long recording take little memory and are complete in the file."""

import pytest
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import Writer

from drill_twin.io.bag.file_writer import PackedIndices
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import TWIN_SCENE

TOPICS = range(1, 14)
SIZE = 41_234  # bytes of a chunk


def _index(k):
    offsets = {topic: k * SIZE + 9_000 + 173 * topic for topic in TOPICS}
    begin = 1_700_000_000_000_000_000 + k * 100_123_457
    return ChunkIndex(
        chunk_length=SIZE - k % 97,
        chunk_start_offset=k * SIZE,
        compression="zstd",
        compressed_size=SIZE - 80,
        message_end_time=begin + 99_000_000,
        message_index_length=1_700,
        message_index_offsets=offsets,
        message_start_time=begin,
        uncompressed_size=3 * SIZE,
    )


@pytest.mark.slow
def test_an_hour_of_chunks_is_kept_in_a_few_megabytes_and_comes_back():
    kept = PackedIndices()
    for k in range(36_000):
        kept.append(_index(k))
    assert sum(map(len, kept._packed)) < 4_000_000
    assert all(one == _index(k) for k, one in enumerate(kept))
    assert sum(1 for _ in kept) == 36_000


def test_the_writer_keeps_them_so_and_every_chunk_is_found_again(tmp_path):
    raw = encode_string("text")
    with BagWriter(tmp_path / "run_0", topics=[TWIN_SCENE]) as bag:
        assert isinstance(vars(bag._files[0]._writer)["_Writer__chunk_indices"], PackedIndices)
        for k in range(600):
            bag.write(TWIN_SCENE, k, raw)
            bag.flush()
    with bag.file.open("rb") as stream:
        reader = make_reader(stream)
        assert len(reader.get_summary().chunk_indexes) == 600
        assert [message.log_time for _, _, message in reader.iter_messages()] == list(range(600))


def test_mcap_still_has_the_list_that_is_replaced(tmp_path):
    with (tmp_path / "a.mcap").open("wb") as stream:
        assert vars(Writer(stream))["_Writer__chunk_indices"] == []
