# SPDX-License-Identifier: Apache-2.0
"""Keeps a checkpoint of the run on the disk, without holding up the loop: a disk may take its time."""

from __future__ import annotations

import threading

from drill_twin.errors import CheckpointError
from drill_twin.twin.checkpoint import Checkpoint


class CheckpointWriter:
    """Writes one checkpoint at a time, in a thread; one that comes while it writes is left out."""

    def __init__(self) -> None:
        self._writing: threading.Thread | None = None
        self.kept: float | None = None
        """Simulated time of the last one that is on the disk [s]."""
        self.trouble = ""
        """Why the last one could not be written; empty when it could."""

    def keep(self, checkpoint: Checkpoint, path: str) -> None:
        """Begin to write one."""
        if self._writing is not None and self._writing.is_alive():
            return
        self._writing = threading.Thread(target=self._write, args=(checkpoint, path), name="checkpoint")
        self._writing.start()

    def finish(self) -> None:
        """Wait until it is written."""
        if self._writing is not None:
            self._writing.join()

    def _write(self, checkpoint: Checkpoint, path: str) -> None:
        try:
            checkpoint.save(path)
        except CheckpointError as error:
            self.trouble = str(error)
            return
        self.kept, self.trouble = checkpoint.time, ""
