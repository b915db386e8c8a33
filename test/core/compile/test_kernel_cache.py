# SPDX-License-Identifier: Apache-2.0
"""Cache of compiled kernels: damaged, cut, planted, full, read-only, or cold for two processes at once."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from forked import Forked
from variants import one_of

from drill_twin.core.compile.kernel_cache import load_generated
from drill_twin.core.errors import RunError
from drill_twin.core.files import kept_files
from drill_twin.core.files.kept_files import cache_folder
from drill_twin.studies.accuracy import error_model
from drill_twin.studies.accuracy.error_model import ErrorModel, load_model, save_model

ROOT = Path(__file__).parents[3]
USE = '''
import sys, numpy as np
from drill_twin.core.compile.kernel_cache import load_generated
FACTOR = 3.0 if "other" in sys.argv else 2.0
module = load_generated("probe", f"""
factor = {FACTOR}
from drill_twin.core.compile.jit import entry_kernel
@entry_kernel
def total(values, factor):
    found = 0.0
    for k in range(values.size):
        found += values[k] * factor
    return found
""")
if "limited" in sys.argv:
    import resource, signal
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
print(module.total(np.arange(3.0), FACTOR), "hit" if module.total.stats.cache_hits else "compiled")
if "told" in sys.argv:
    print("numba.typed.typeddict" in sys.modules)
'''


STRANGER = 65534


def use(folder, *arguments, stranger=False):
    """Result of the kernel in a new process, and the lines on stderr."""
    done = start(folder, *arguments, stranger=stranger)
    out, err = done.communicate(timeout=120)
    assert done.returncode == 0, err
    return out.strip(), err.splitlines()


def start(folder, *arguments, stranger=False):
    if not (stranger or "told" in arguments):
        return Forked(USE, arguments, environment={"DRILL_TWIN_CACHE": str(folder)})
    environment = dict(os.environ, DRILL_TWIN_CACHE=str(folder), PYTHONPATH=str(ROOT))
    # Another user may read all here, so that he can run the Python of root.
    become = [*f"setpriv --reuid {STRANGER} --inh-caps +dac_read_search --ambient-caps +dac_read_search".split()]
    command = [*(become if stranger else []), sys.executable, "-c", USE, *arguments]
    return subprocess.Popen(command, env=environment, stdout=-1, stderr=-1, text=True)


@pytest.mark.parametrize(("kind", "told"), [("linear", "False"), ("probe", "True")])
def test_kept_machine_code_that_does_not_allocate_needs_no_compiler(tmp_path, monkeypatch, kind, told):
    """numba imports all that it can compile, which takes 0.2 s, before it reads a kept function."""
    monkeypatch.setattr(sys.modules[__name__], "USE", USE.replace('"probe"', f'"{kind}"'))
    assert use(tmp_path / "kernels", "told") == ("6.0 compiled\nTrue", [])
    assert use(tmp_path / "kernels", "told") == (f"6.0 hit\n{told}", [])


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache") / "kernels"
    assert use(folder) == ("6.0 compiled", [])
    assert use(folder) == ("6.0 hit", [])
    return folder


@pytest.fixture
def folder(filled, tmp_path):
    copy = tmp_path / "kernels"
    copy.mkdir(mode=0o700)
    for file in filled.iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
        (copy / file.name).chmod(0o600)
    return copy


def _flipped(content):
    random, changed = np.random.default_rng(15), bytearray(content)
    changed[int(random.integers(len(changed)))] ^= 1
    return bytes(changed)


DAMAGE = {
    "one bit": _flipped,
    "cut": lambda content: content[: len(content) // 2],
    "others": lambda content: os.urandom(len(content)),
    "empty": lambda _: b"",
    "longer": lambda content: content + b"\0",
}


@pytest.mark.parametrize("damage", one_of(5, DAMAGE))
def test_a_damaged_cache_is_made_again_with_one_line(damage, folder):
    for file in folder.iterdir():
        file.write_bytes(DAMAGE[damage](file.read_bytes()))
    said, lines = use(folder)
    assert said == "6.0 compiled"
    assert len(lines) == 1
    assert re.search(r"machine_code: damaged, made again$", lines[0])
    assert use(folder) == ("6.0 hit", [])


def test_two_processes_on_a_cold_cache(tmp_path):
    both = [start(tmp_path / "kernels") for _ in range(2)]
    said = [process.communicate(timeout=120) for process in both]
    assert said[0][1] == said[1][1] == ""
    # Whichever is later may find what the other has just kept.
    assert sorted(out for out, _ in said) in (["6.0 compiled\n"] * 2, ["6.0 compiled\n", "6.0 hit\n"])
    assert use(tmp_path / "kernels") == ("6.0 hit", [])
    assert not list((tmp_path / "kernels").glob("*.part"))


def test_a_full_disk(tmp_path):
    said, lines = use(tmp_path / "kernels", "limited")
    assert said == "6.0 compiled"
    assert len(lines) == 1
    assert "made, but not kept: File too large" in lines[0]
    assert not list((tmp_path / "kernels").glob("*.part"))
    assert use(tmp_path / "kernels") == ("6.0 compiled", [])


def test_an_open_folder_of_ours_is_closed_and_open_files_in_it_are_not_run(folder):
    folder.chmod(0o777)
    planted = next(folder.glob("*.machine_code"))
    planted.chmod(0o666)
    said, lines = use(folder)
    assert said == "6.0 compiled"
    assert "of another user, or writable by others" in lines[0]
    assert folder.stat().st_mode & 0o777 == 0o700
    assert planted.stat().st_mode & 0o777 == 0o600


def test_a_new_folder_is_ours_alone(filled):
    assert filled.stat().st_mode & 0o777 == 0o700
    assert all(file.stat().st_mode & 0o777 == 0o600 for file in filled.iterdir())


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_what_another_user_made_is_refused(folder, monkeypatch, tmp_path):
    planted = next(folder.glob("*.machine_code"))
    os.chown(planted, 12345, -1)
    assert use(folder)[0] == "6.0 compiled"
    os.chown(folder, 12345, -1)
    monkeypatch.setenv("DRILL_TWIN_CACHE", str(folder))
    with pytest.raises(RunError, match=r"expected a folder of your own .* a folder of user 12345.* name another"):
        cache_folder()
    monkeypatch.delenv("DRILL_TWIN_CACHE")
    (tmp_path / "home" / "drill_twin").mkdir(parents=True)
    os.chown(tmp_path / "home" / "drill_twin", 12345, -1)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    assert cache_folder().stat().st_uid == 0


GOOD_MODEL = {
    "key": "a", "onset_s": None, "covered_s": 1.0, "elements": 8, "step": 0.01, "ended": "reached",
    "points": [
        {"elements": 8, "step": 0.01, "tolerance": 1e-4, "path": 0.1, "onset": 0.0, "before": 1.0, "after": 1.0},
    ],
}  # fmt: skip


def _model(*point: object, **changes: object) -> bytes:
    points = [{**GOOD_MODEL["points"][0], **dict([point])}] if point else GOOD_MODEL["points"]
    return json.dumps({**GOOD_MODEL, "points": points, **changes}).encode()


@pytest.mark.parametrize(
    "content",
    [
        b"", b"{", b"[]", b"\xff\xfe", b'{"points": 3}', b"[" * 100_000, b'{"points": ' * 100_000, b"\x00" * 3_000_000,
        b"null", "{\u202e}".encode(), _model(elements="8"), _model(elements=10**400), _model(elements=0),
        _model(step=float("nan")), _model(step=0.0), _model(covered_s=None), _model(points={}), _model(points=[None]),
        _model("elements", 1e9), _model("before", float("nan")), _model("before", float("inf")), _model("path", "0.1"),
        _model("tolerance", -1.0), _model("after", True), _model(key=["a"]),
    ],
)  # fmt: skip
def test_a_damaged_error_model_counts_as_none(content, bench_scene, monkeypatch, tmp_path):
    monkeypatch.setattr(error_model, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(error_model, "cached_file", lambda name: tmp_path / name)
    key = error_model.content_key(bench_scene)
    save_model(ErrorModel(key, None, 1.0, 8, 0.01, "reached", ()))
    assert load_model(bench_scene) == (ErrorModel(key, None, 1.0, 8, 0.01, "reached", ()), "cached")
    file = next((tmp_path / error_model.FOLDER).iterdir())
    file.write_bytes(content)
    assert load_model(bench_scene) is None
    save_model(ErrorModel(key, None, 1.0, 8, 0.01, "reached", ()))
    file.chmod(0o666)
    assert load_model(bench_scene) is None
    assert kept_files.read_own(file) is None


def test_an_error_model_is_read_as_it_was_written(tmp_path):
    infinite = ErrorModel.parse(_model("path", float("inf")))
    assert infinite.points[0].path == float("inf")
    infinite.save(tmp_path / "model.json")
    assert ErrorModel.parse((tmp_path / "model.json").read_bytes()) == infinite


def test_threads_that_ask_for_one_module_get_it_whole(tmp_path, monkeypatch):
    """Members of an ensemble are built by threads, each of which loads the kernel."""
    monkeypatch.setenv("DRILL_TWIN_CACHE", str(tmp_path))
    text = "import time\nfrom drill_twin.physics.effects import gravity\ntime.sleep(0.05)\nlast = {}\n"
    with ThreadPoolExecutor(8) as pool:
        lasts = list(pool.map(lambda k: load_generated("test", text.format(k // 4)).last, range(40)))
    assert lasts == [k // 4 for k in range(40)]


READ_ONLY = {
    "taken away": "the right to write is taken away",
    "mounted": "the disk is mounted read-only",
    "of root": "root has made it for all",
}


@pytest.fixture(params=READ_ONLY)
def read_only(request, filled):
    """A warm cache that cannot be written to; True if the process is that of another user than this one."""
    place = Path(tempfile.mkdtemp(prefix="drill_twin_test_"))
    place.chmod(0o755)
    cache = shutil.copytree(filled, place / "kernels")
    stranger = os.geteuid() == 0
    if request.param == "taken away":
        if stranger:
            for file in (cache, *cache.iterdir()):
                os.chown(file, STRANGER, STRANGER)
        for file in cache.iterdir():
            file.chmod(0o400)
        cache.chmod(0o500)
    elif os.geteuid() != 0:
        pytest.skip("only root can mount, and make a folder of root")
    elif request.param == "mounted":
        stranger = False
        for options in (["--bind", str(cache), str(cache)], ["-o", "remount,bind,ro", str(cache)]):
            if subprocess.run(["mount", *options], capture_output=True, check=False).returncode:
                pytest.skip("cannot mount here")
    else:
        for file in cache.iterdir():
            file.chmod(0o644)
        cache.chmod(0o755)
    yield cache, stranger
    if request.param == "mounted":
        subprocess.run(["umount", str(cache)], check=True)
    cache.chmod(0o700)
    shutil.rmtree(place)


def test_a_warm_cache_that_cannot_be_written_to_is_used_and_left_as_it_is(read_only):
    cache, stranger = read_only

    def content():
        return {file: (file.stat().st_mtime_ns, file.stat().st_mode) for file in (cache, *cache.rglob("*"))}

    before = content()
    assert use(cache, stranger=stranger) == ("6.0 hit", [])
    assert content() == before
    # What is not in it is compiled, in every process.
    assert use(cache, "other", stranger=stranger) == ("9.0 compiled", [])
    assert content() == before


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make a folder of root")
def test_a_folder_of_root_that_others_can_write_to_is_refused():
    place = Path(tempfile.mkdtemp(prefix="drill_twin_test_"))
    place.chmod(0o777)
    try:
        process = start(place, stranger=True)
        said = process.communicate(timeout=120)[1]
    finally:
        place.rmdir()
    assert process.returncode == 1
    assert "a folder in which other users could put programs" in said
