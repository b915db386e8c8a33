# SPDX-License-Identifier: Apache-2.0
"""Compilation of the kernels of a scene, with progress: in a child process that fills the cache of compiled kernels.

numba and LLVM hold a process for seconds at a time, in which it answers no service and no signal. The child leaves the
process free; loading the machine code from the cache afterwards takes a tenth of a second.

The time that it takes depends on the machine and on the effects, so the progress names the last compilation,
which is kept with the compiled kernels. No share of the time is told: one function takes up to a hundred times as
long as another.
"""

import json
import logging
import os
import pickle
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from drill_twin.core.compile.kernel_cache import NotCachedError, from_cache_only
from drill_twin.core.errors import RunStopped
from drill_twin.core.files.json_files import read_json
from drill_twin.core.files.kept_files import permanent_folder, read_own
from drill_twin.core.files.output import PRIVATE, write_whole
from drill_twin.core.process import child_environment
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl import Analyzer

_LOG = logging.getLogger(__name__)

_NAME = "last_compilation.json"


class LastCompilation:
    """Number of functions and wall-clock time of the last compilation: what the next may take."""

    functions, seconds = 0, 0.0
    """Both 0 where none is known."""

    def __init__(self, folder: Path) -> None:
        """Read them.

        Args:
            folder: Folder of compiled kernels.
        """
        self._path = folder / _NAME
        try:
            functions, seconds = read_json(read_own(self._path) or b"[0, 0]")
            self.functions, self.seconds = int(functions), float(seconds)
        except (ValueError, TypeError, RecursionError):
            pass  # a damaged file tells nothing; the next is written over it

    def __str__(self) -> str:
        """Time that the compilation is expected to take."""
        if self.seconds > 0.0:
            return f"the last compilation took {self.seconds:.0f} s"
        return "ten seconds to two minutes on most machines"

    def text(self, functions: int, seconds: float) -> str:
        """Progress after a number of functions and a wall-clock time [s]."""
        of = f" of about {self.functions}" if functions < self.functions else ""
        return f"{functions}{of} functions, {seconds:.0f} s; {self}"

    def keep(self, functions: int, seconds: float) -> None:
        """Keep functions and time [s] of this compilation for the next."""
        try:
            write_whole(self._path, json.dumps([functions, seconds]), PRIVATE)
        except OSError as error:
            _LOG.warning("%s: not kept: %s", self._path, error.strerror or error)


COMPILING = "compiling the effects of the scene"
"""First words of each text of progress."""
_POLL = 0.1  # s between two reports
_READ = 4096  # bytes


def compile_kernel(
    scene: Scene, period: float, progress: Callable[[str], None] | None = None, *, analysis: bool = False
) -> None:
    """Compile the kernels of a scene, or load them from the cache, by the first frame of a twin that is then dropped.

    Args:
        scene: The scene.
        period: Simulated time of a frame [s].
        progress: Called with the progress in words ten times a second while a child process compiles; may raise, which
            ends the compilation. None: compile in this process.
        analysis: Whether the whirl analysis is needed too; a child process always compiles it, for the analyzer node.

    Raises:
        DrillTwinError: The scene cannot be run (as `Twin`).
    """
    if progress is not None:
        try:
            with from_cache_only():
                first_frame(scene, period, analysis=analysis)
            return
        except NotCachedError:
            _compile_in_child(scene, period, progress)
    first_frame(scene, period, analysis=analysis)


def first_frame(scene: Scene, period: float, *, analysis: bool = False) -> None:
    """Call everything that a run of the scene calls, once; of a long frame the first slice."""

    def end() -> None:
        raise RunStopped

    twin = Twin(scene)
    twin.load()
    with checked(end), suppress(RunStopped):
        twin.advance(Command(*scene.rig.first), period)
    if analysis and scene.string.marks:
        Analyzer(mark_infos(scene))


def _compile_in_child(scene: Scene, period: float, progress: Callable[[str], None]) -> None:
    """Fill the cache in a child process; where that is not possible, report so and return."""
    folder = permanent_folder()
    if folder is None:
        progress(f"{COMPILING} in this process: the folder of compiled kernels cannot be written to")
        return
    last, began = LastCompilation(folder), time.monotonic()
    progress(f"{COMPILING}, once for this set of effects: {last}")
    with tempfile.TemporaryFile() as given:
        pickle.dump((scene, period), given)
        given.seek(0)
        child = subprocess.Popen(
            [sys.executable, "-m", "drill_twin.runs.compile_worker", str(given.fileno())],
            env=child_environment({**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}),
            stdin=subprocess.PIPE,  # the child ends when this pipe does, so it never outlives this process
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # an error of the scene comes again in this process
            pass_fds=(given.fileno(),),
            start_new_session=True,  # Ctrl-C reaches this process only
        )
    try:
        functions = _follow(child, lambda n: progress(f"{COMPILING}: {last.text(n, time.monotonic() - began)}"))
    finally:
        child.kill()
        child.communicate()
    if child.returncode == 0:
        last.keep(functions, time.monotonic() - began)
    else:
        progress(f"{COMPILING} in this process: the child process ended with code {child.returncode}")


def _follow(child: subprocess.Popen[bytes], report: Callable[[int], None]) -> int:
    """Report and return the number of functions that a child compiles, until it ends: it writes a byte for each."""
    functions, pipe = 0, child.stdout
    while pipe is not None:
        if select.select([pipe], [], [], _POLL)[0]:
            if not (read := os.read(pipe.fileno(), _READ)):
                break
            functions += len(read)
        report(functions)
    child.wait()
    return functions
