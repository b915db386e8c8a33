# SPDX-License-Identifier: Apache-2.0
"""Checkpoints written to the disk in the background, so that a slow disk does not delay the loop."""

from __future__ import annotations

import threading

from drill_twin.core.errors import CheckpointError
from drill_twin.dynamics.twin.checkpoint import Checkpoint


class CheckpointWriter:
    """Writes one checkpoint at a time, in a thread; another that is due meanwhile is left out."""

    def __init__(self) -> None:
        self._writing: threading.Thread | None = None
        self.written: float | None = None
        """Simulated time of the last one that is on the disk [s]."""
        self.trouble = ""
        """Reason why the last one could not be written; empty when it could."""

    def start(self, checkpoint: Checkpoint, path: str) -> None:
        """Start to write one, unless one is being written."""
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
        self.written, self.trouble = checkpoint.time, ""
