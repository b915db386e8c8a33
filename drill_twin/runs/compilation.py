# SPDX-License-Identifier: Apache-2.0
"""Compilation of the kernels of a scene, with progress: in a child process that fills the cache of compiled kernels.

numba and LLVM hold a process for seconds at a time, in which it answers no service and no signal. The child leaves the
process free; loading the machine code from the cache afterwards takes a tenth of a second.

No share of the time is told: one function takes up to a hundred times as long as another.
"""

import os
import pickle
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress

from drill_twin.core.compile.kernel_cache import NotCachedError, from_cache_only
from drill_twin.core.errors import RunStopped
from drill_twin.core.files.kept_files import permanent_folder
from drill_twin.core.process import child_environment
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl import Analyzer

COMPILING = "compiling the effects of the scene"
"""First words of each text of progress."""
_TIME = "ten seconds to two minutes on most machines"
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
    if permanent_folder() is None:
        progress(f"{COMPILING} in this process: the folder of compiled kernels cannot be written to")
        return
    began = time.monotonic()
    progress(f"{COMPILING}, once for this set of effects: {_TIME}")
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
        _follow(child, lambda n: progress(f"{COMPILING}: {n} functions, {time.monotonic() - began:.0f} s; {_TIME}"))
    finally:
        child.kill()
        child.communicate()
    if child.returncode != 0:
        progress(f"{COMPILING} in this process: the child process ended with code {child.returncode}")


def _follow(child: subprocess.Popen[bytes], report: Callable[[int], None]) -> None:
    """Report the number of functions that a child compiles, until it ends: it writes a byte for each."""
    functions, pipe = 0, child.stdout
    while pipe is not None:
        if select.select([pipe], [], [], _POLL)[0]:
            if not (read := os.read(pipe.fileno(), _READ)):
                break
            functions += len(read)
        report(functions)
    child.wait()
