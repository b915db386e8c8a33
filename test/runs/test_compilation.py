# SPDX-License-Identifier: Apache-2.0
"""Compilation in a child process: it fills the cache, reports, and ends with its parent or on request."""

import os
import pickle
import signal
import subprocess
import sys
import tempfile

import pytest

from drill_twin.core.compile.kernel_cache import NotCachedError, before_each_compilation, from_cache_only
from drill_twin.runs import compilation
from drill_twin.runs.compile_worker import STOPPED
from drill_twin.scene import load_scene

PERIOD = 0.01  # s


@pytest.fixture(scope="module")
def scene():
    return load_scene("pa6_bench", overrides={"numerics.elements": "8"})


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("DRILL_TWIN_CACHE", str(tmp_path / "cache"))
    for name in [name for name in sys.modules if name.startswith("drill_twin_")]:  # kernels of other tests
        monkeypatch.delitem(sys.modules, name)
    return tmp_path / "cache"


def test_a_warm_cache_starts_no_child_and_reports_nothing(scene):
    compilation.compile_kernel(scene, PERIOD)
    compilation.compile_kernel(scene, PERIOD, pytest.fail)


def test_with_an_empty_cache_nothing_is_compiled_in_this_process(empty_cache, scene):
    with pytest.raises(NotCachedError), from_cache_only():
        compilation.first_frame(scene, PERIOD)


def test_a_report_that_raises_ends_the_child(empty_cache, scene, monkeypatch):
    children = []
    start = subprocess.Popen

    def started(*given, **more):
        children.append(start(*given, **more))
        return children[-1]

    def report(text):
        if " functions, " in text:
            raise KeyboardInterrupt

    monkeypatch.setattr(compilation.subprocess, "Popen", started)
    with pytest.raises(KeyboardInterrupt):
        compilation.compile_kernel(scene, PERIOD, report)
    assert children[0].returncode == -signal.SIGKILL


def test_the_child_ends_with_its_parent(empty_cache, scene):
    with tempfile.TemporaryFile() as given:
        pickle.dump((scene, PERIOD), given)
        given.seek(0)
        child = subprocess.Popen(
            [sys.executable, "-m", "drill_twin.runs.compile_worker", str(given.fileno())],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(given.fileno(),),
        )
    assert child.stdout.read(1) == b"."  # it compiles
    child.stdin.close()
    assert child.wait(60.0) == STOPPED
    child.stdout.close()


def test_a_cache_that_cannot_be_shared_is_reported(scene, monkeypatch):
    texts = []
    monkeypatch.setattr(compilation, "permanent_folder", lambda: None)
    monkeypatch.setattr(compilation, "from_cache_only", _nothing_cached)
    compilation.compile_kernel(scene, PERIOD, texts.append)
    assert len(texts) == 1
    assert "in this process" in texts[0]


def _nothing_cached():
    raise NotCachedError


@pytest.mark.long
def test_the_child_fills_the_cache_for_this_process(empty_cache, scene):
    texts, here = [], []
    with before_each_compilation(lambda: here.append(1)):
        compilation.compile_kernel(scene, PERIOD, texts.append, analysis=True)
    assert any(" functions, " in text and ": 0 functions" not in text for text in texts)
    # One attempt was refused; the rest came from the cache.
    assert len(here) == 1
    assert any(empty_cache.rglob("*.machine_code"))
