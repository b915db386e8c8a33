# SPDX-License-Identifier: Apache-2.0
"""Files that are no scene at all end in one clear line, quickly, and never in a traceback."""

import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drill_twin.core.errors import SceneError
from drill_twin.scene import load_scene, parse_scene

LAUGHS = "".join(f"k{level}: &a{level} [{', '.join([f'*a{level - 1}' if level else 'x'] * 9)}]\n" for level in range(9))

TEXTS = {
    "empty": ("", "an empty file"),
    "only a comment": ("# nothing\n", "an empty file"),
    "a list": ("[1, 2]", "found a list"),
    "a word": ("hello", 'found the text "hello"'),
    "nothing": ("null", "expected keys"),
    "two documents": ("a: 1\n---\nb: 2", "x.yaml:2: column 1: expected valid YAML, found: another document"),
    "a tab": ("a:\n\tb: 1", "x.yaml:2"),
    "an open quote": ('a: 1\nb: "x\n', "from line 2 on"),
    "a stray brace": ("a: }", "x.yaml:1: column 4"),
    "duplicate keys": ("a: 1\nb: 2\na: 3", "x.yaml:3: expected each key once, found `a` again (first in line 1)"),
    "nested duplicate keys": ("a:\n  b: 1\n  b: 2", "x.yaml:3: expected each key once"),
    "a python tag": ("a: !!python/object:os.system {}", "found the YAML tag"),
    "a tag of one's own": ("a: !mine 3", "found the YAML tag !mine"),
    "a merge": ("a: {<<: {b: 1}}", "YAML merge"),
    "a list as key": ("? [a]\n: 1", "expected a name as key"),
    "an alias of itself": ("a: &a [*a]", "endless repetition"),
    "a billion laughs": (LAUGHS, "endless repetition"),
    "deep nesting": ("[" * 100_000, "nested blocks"),
    "deep indent": ("- " * 100_000, "nested blocks"),
    "binary": ("\0\1\2", "control characters"),
    "a PDF": ("%PDF-1.4\n", "expected valid YAML"),
    "too long": ("a: " + "x" * 1_000_000, "at most 1000000 characters"),
}


@pytest.mark.parametrize("text, words", TEXTS.values(), ids=TEXTS)  # noqa: PT006
def test_a_text_that_is_no_scene_is_refused_in_one_line(text, words):
    begun = time.process_time()
    with pytest.raises(SceneError) as caught:
        parse_scene(text, name="x.yaml")
    assert time.process_time() - begun < 5.0
    assert words in str(caught.value)
    assert str(caught.value).startswith("x.yaml")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@settings(deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_a_scene_error(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    assert "\n" not in str(caught.value)


@settings(deadline=None)
@given(st.data())
def test_a_scene_with_anything_in_place_of_a_value_is_a_scene_or_a_scene_error(good, data):
    lines = good.splitlines()
    number = data.draw(st.integers(0, len(lines) - 1))
    key, _, _ = lines[number].partition(": ")
    lines[number] = f"{key}: {data.draw(st.text(max_size=30))}"
    try:
        parse_scene("\n".join(lines))
    except SceneError as error:
        assert "\n" not in str(error)  # noqa: PT017


def test_a_folder_a_missing_file_and_bytes_are_told_apart(tmp_path: Path):
    with pytest.raises(SceneError, match="found a folder"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match="no such scene file"):
        load_scene(tmp_path / "missing.yaml")
    (tmp_path / "bytes.yaml").write_bytes(b"\xd0\xff\xfe")
    with pytest.raises(SceneError, match="expected text in UTF-8"):
        load_scene(tmp_path / "bytes.yaml")
    (tmp_path / "huge.yaml").write_bytes(b"#" * 2_000_000)
    with pytest.raises(SceneError, match="at most 1000000 bytes, found 2000000"):
        load_scene(tmp_path / "huge.yaml")


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path: Path, good: str):
    (tmp_path / "windows.yaml").write_bytes(b"\xef\xbb\xbf" + good.replace("\n", "\r\n").encode())
    assert load_scene(tmp_path / "windows.yaml") == parse_scene(good)
