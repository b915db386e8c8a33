# SPDX-License-Identifier: Apache-2.0
"""Child process of `drill_twin.runs.compilation`: compiles the kernels of a scene into the cache.

Its argument is the file descriptor of the pickled arguments of `first_frame`. It writes a byte to standard output for
each function that it compiles, and ends when its standard input does.
"""

import gc
import os
import pickle
import sys
import threading

STOPPED = 3
"""Exit code after the end of standard input."""


def main() -> None:
    """Compile, without collection of garbage: a compiler makes millions of objects, and the process ends soon."""
    gc.disable()
    progress = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what an effect prints must not be counted
    threading.Thread(target=_end_with_input, daemon=True).start()
    from drill_twin.core.compile.kernel_cache import before_each_compilation
    from drill_twin.runs.compilation import first_frame

    with os.fdopen(int(sys.argv[1]), "rb") as given:
        scene, period = pickle.load(given)  # noqa: S301 - written by the parent process
    with before_each_compilation(lambda: _write_byte(progress)):
        first_frame(scene, period, analysis=True)


def _write_byte(progress: int) -> None:
    os.write(progress, b".")


def _end_with_input() -> None:
    os.read(sys.stdin.fileno(), 1)
    os._exit(STOPPED)


if __name__ == "__main__":
    main()
