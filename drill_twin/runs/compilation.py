# SPDX-License-Identifier: Apache-2.0
"""Compilation of the kernels of a scene, with progress: in a child process that fills the cache of compiled kernels.

numba and LLVM hold a process for seconds at a time, in which it answers no service and no signal. The child leaves the
process free; loading the machine code from the cache afterwards takes a tenth of a second.

The time that it takes depends on the machine and on the effects. The share done follows from the course of the last
compilation of the same kind, which is kept with the compiled kernels. One function takes up to a hundred times as long
as another, so the last course turns the number of compiled functions into a share of the time: it has the time at which
each number was reached.
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

import numpy as np

from drill_twin.core.compile.kernel_cache import NotCachedError, fingerprint, from_cache_only
from drill_twin.core.errors import RunStopped
from drill_twin.core.files.json_files import read_json
from drill_twin.core.files.kept_files import permanent_folder, read_own
from drill_twin.core.files.output import PRIVATE, write_whole
from drill_twin.core.process import child_environment
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin import observation
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl import Analyzer

_LOG = logging.getLogger(__name__)

EMPTY, FURTHER = "empty", "further"
"""Kinds: with an empty cache, which compiles what all scenes share too; with machine code of other effects."""
FIRST_COURSE = ((0, 0.0), (46, 0.12), (114, 0.4), (160, 0.43), (185, 0.74), (231, 0.81), (285, 1.0))
"""Functions and share of the time with an empty cache, scene pa6_bench."""
_POINTS = 24
_NAME = "compile_course_{}.json"


class CompileShare:
    """Text of the progress of a compilation; `save` keeps its course for the next."""

    def __init__(self, folder: Path) -> None:
        """Read the course of the last compilation of the same kind.

        Args:
            folder: Folder of compiled kernels.
        """
        module = observation.__name__
        shared = f"part_{module}.{observation.observe_nodes.__name__}_{fingerprint(f'import {module}')}.*"
        kind = FURTHER if next(folder.glob(shared), None) else EMPTY
        self._path = folder / _NAME.format(kind)
        self._seen: list[tuple[int, float]] = []
        self._seconds = 0.0
        """Wall-clock time of the last compilation [s]; 0 where it is not known."""
        self._course = np.array(FIRST_COURSE if kind == EMPTY else ())
        try:
            course = np.array(read_json(read_own(self._path) or b"[]"), float)
            if course.ndim == 2 and course.shape[1] == 2 and np.all(np.isfinite(course)) and course[-1, 1] > 0.0:
                self._seconds = float(course[-1, 1])
                self._course = course / (1.0, self._seconds)
        except (ValueError, TypeError, RecursionError):
            pass  # a damaged file is no course; the next course is written over it

    @property
    def before(self) -> str:
        """Time that the compilation is expected to take, in words, before it begins."""
        if self._seconds:
            return f"the last such took {self._seconds:.0f} s"
        return f"{'one' if self._course.size else 'ten seconds'} to two minutes on most machines"

    def text(self, functions: int, seconds: float) -> str:
        """Progress after a number of functions and a wall-clock time [s]."""
        if not self._seen or functions > self._seen[-1][0]:
            self._seen.append((functions, seconds))
        if not self._course.size or functions >= self._course[-1, 0]:
            return f"{functions} functions, {seconds:.0f} s"
        share = float(np.interp(functions, *self._course.T))
        left = f", about {seconds * (1.0 - share) / share:.0f} s left" if share >= 0.1 else ""
        return f"{functions} of about {self._course[-1, 0]:.0f} functions, {seconds:.0f} s; {share:.0%} done{left}"

    def save(self, seconds: float) -> None:
        """Keep the course of this compilation, which took a wall-clock time [s]."""
        if self._seen:
            chosen = self._seen[:: max(1, len(self._seen) // _POINTS)]
            try:
                write_whole(self._path, json.dumps([*chosen, (self._seen[-1][0], seconds)]), PRIVATE)
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
    share, began = CompileShare(folder), time.monotonic()
    progress(f"{COMPILING}, once for this set of effects: {share.before}")
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
        _follow(child, lambda functions: progress(f"{COMPILING}: {share.text(functions, time.monotonic() - began)}"))
    finally:
        child.kill()
        child.communicate()
    if child.returncode == 0:
        share.save(time.monotonic() - began)
    else:
        progress(f"{COMPILING} in this process: the child process ended with code {child.returncode}")


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
