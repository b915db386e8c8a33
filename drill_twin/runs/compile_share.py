# SPDX-License-Identifier: Apache-2.0
"""Share done of a compilation, from the course of the last one like it, which is kept with the compiled kernels.

How long it takes depends on the machine and on the effects; functions differ by a hundred times, so the number compiled
is turned into a share of the time by the times at which the last compilation had as many.
"""

from __future__ import annotations

import json
import logging
from pathlib import Path

import numpy as np

from drill_twin.core.compile.kernel_cache import fingerprint
from drill_twin.core.compile.object_cache import read_own
from drill_twin.core.files.json_reader import read_json
from drill_twin.core.files.whole_file import PRIVATE, write_whole
from drill_twin.dynamics.twin import observation

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
        """Read the course of the last compilation like the one that begins.

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
            pass  # damaged: as without one; the next is written over it

    @property
    def before(self) -> str:
        """Time to expect, before it begins."""
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
        left = f", about {seconds * (1.0 - share) / share:.0f} s left" if share > 0.02 else ""
        return f"{functions} of about {self._course[-1, 0]:.0f} functions, {seconds:.0f} s; {share:.0%} done{left}"

    def save(self, seconds: float) -> None:
        """Keep the course of this compilation, which took a wall-clock time [s]."""
        if self._seen:
            chosen = self._seen[:: max(1, len(self._seen) // _POINTS)]
            try:
                write_whole(self._path, json.dumps([*chosen, (self._seen[-1][0], seconds)]), PRIVATE)
            except OSError as error:
                _LOG.warning("%s: not kept: %s", self._path, error.strerror or error)
