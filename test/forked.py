# SPDX-License-Identifier: Apache-2.0
"""Processes that begin with numba imported: forked from the process of the tests, which has done that already.

Half of the processor time of a small program that compiles is the import of numba. What is forked here has arguments,
environment and output of its own, and none of the handlers that the tests put on the log.
"""

import logging
import os
import sys
import tempfile
import traceback


class Forked:
    """A program in a process of its own; the part of `subprocess.Popen` that tests use."""

    def __init__(self, code, arguments, *, environment, forget=(), path=None):
        """Start it.

        Args:
            code: Text of the program.
            arguments: Its arguments.
            environment: Variables that differ from those of this process.
            forget: Packages that it imports anew.
            path: Folder in which it looks for packages first.
        """
        self.returncode = None
        self._files = [tempfile.TemporaryFile("w+", encoding="utf-8") for _ in range(2)]  # noqa: SIM115
        self._pid = os.fork()
        if self._pid == 0:
            ended = 1
            try:
                self._become(arguments, environment, forget, path)
                exec(compile(code, "<forked>", "exec"), {"__name__": "__main__"})  # noqa: S102  the text is of a test
                ended = 0
            except BaseException:  # noqa: BLE001 - as an interpreter does
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(ended)

    def _become(self, arguments, environment, forget, path):
        for file, target in zip(self._files, (1, 2), strict=True):
            os.dup2(file.fileno(), target)
        sys.stdout, sys.stderr = (open(target, "w", encoding="utf-8", closefd=False) for target in (1, 2))  # noqa: PTH123, SIM115
        logging.getLogger().handlers.clear()
        os.environ.update(environment)
        sys.argv = ["-c", *map(str, arguments)]
        for name in [*sys.modules]:
            if name.partition(".")[0] in forget:
                del sys.modules[name]
        if path is not None:
            sys.path.insert(0, str(path))
            os.chdir(path)

    def communicate(self, timeout=None):
        """Wait for its end; what it has written to stdout and to stderr."""
        del timeout
        self.returncode = os.waitstatus_to_exitcode(os.waitpid(self._pid, 0)[1])
        said = []
        for file in self._files:
            file.seek(0)
            said.append(file.read())
            file.close()
        return tuple(said)
