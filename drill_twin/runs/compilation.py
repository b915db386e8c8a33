# SPDX-License-Identifier: Apache-2.0
"""Compilation of the kernels of a scene, with progress: in a child process that fills the cache of compiled kernels.

numba and LLVM hold a process for seconds at a time, in which it answers no service and no signal. The child leaves the
process free; loading the machine code from the cache afterwards takes a tenth of a second.
"""

from __future__ import annotations

import os
import pickle
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress

from drill_twin.core.compile.compile_events import NotCachedError, from_cache_only
from drill_twin.core.compile.kernel_cache import permanent_folder
from drill_twin.core.errors import RunStopped
from drill_twin.core.process.child_environment import child_environment
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs.compile_share import CompileShare
from drill_twin.runs.monitor.run_timing import EffectTiming
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl import Analyzer

COMPILING = "compiling the effects of the scene"
"""First words of each text of progress."""
_POLL = 0.1  # s between two reports
_READ = 4096  # bytes

Progress = Callable[[str], None]
"""Takes the progress in words; may raise, which ends the compilation."""


def compile_kernel(
    scene: Scene,
    period: float,
    progress: Progress | None = None,
    *,
    time_effects: bool = False,
    analysis: bool = False,
) -> None:
    """Compile the kernels of a scene, or load them from the cache, by the first frame of a twin that is then dropped.

    Args:
        scene: The scene.
        period: Simulated time of a frame [s].
        progress: Called ten times a second while a child process compiles; None: compile in this process.
        time_effects: Whether the functions that measure the cost of each effect are needed too.
        analysis: Whether the whirl analysis is needed too; a child process always compiles it, for the analyzer node.

    Raises:
        DrillTwinError: The scene cannot be run (as `Twin`).
    """
    if progress is not None:
        try:
            with from_cache_only():
                first_frame(scene, period, time_effects=time_effects, analysis=analysis)
        except NotCachedError:
            _compile_in_child(scene, period, progress, time_effects=time_effects)
        else:
            return
    first_frame(scene, period, time_effects=time_effects, analysis=analysis)


def first_frame(scene: Scene, period: float, *, time_effects: bool, analysis: bool = False) -> None:
    """Call everything that a run of the scene calls, once; of a long frame the first slice."""

    def end() -> None:
        raise RunStopped

    twin = Twin(scene)
    twin.load()
    with checked(end), suppress(RunStopped):
        twin.advance(Command(*scene.rig.first), period)
    if time_effects:
        EffectTiming(twin)
    if analysis and scene.string.marks:
        Analyzer(mark_infos(scene))


def _compile_in_child(scene: Scene, period: float, progress: Progress, *, time_effects: bool) -> None:
    """Fill the cache in a child process; where that is not possible, report so and return."""
    folder = permanent_folder()
    if folder is None:
        progress(f"{COMPILING} in this process: the folder of compiled kernels cannot be written to")
        return
    share, began = CompileShare(folder), time.monotonic()
    progress(f"{COMPILING}, once for this set of effects: {share.before}")
    with tempfile.TemporaryFile() as given:
        pickle.dump((scene, period, time_effects), given)
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
        _follow(child, lambda functions: progress(f"{COMPILING}: {share.text(functions, time.monotonic() - began)}"))
    finally:
        child.kill()
        child.communicate()
    if child.returncode == 0:
        share.save(time.monotonic() - began)
    else:
        progress(f"{COMPILING} in this process: the one that should do it ended with code {child.returncode}")


def _follow(child: subprocess.Popen[bytes], report: Callable[[int], None]) -> None:
    """Report the number of functions that a child has compiled, until it ends: it writes a byte for each."""
    functions, pipe = 0, child.stdout
    while pipe is not None:
        if select.select([pipe], [], [], _POLL)[0]:
            if not (read := os.read(pipe.fileno(), _READ)):
                break
            functions += len(read)
        report(functions)
    child.wait()
