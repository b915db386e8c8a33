# SPDX-License-Identifier: Apache-2.0
"""A signal's exception is held back where it would be lost; one thread of BLAS."""

import os
import subprocess
import sys

import llvmlite.binding.executionengine as engine
import pytest

from drill_twin.core.process import is_unraisable

ASK = "def {name}():\n    import sys\n    return ask(sys._getframe())\n"


def asked(name: str, file: str) -> bool:
    """What is said within a function of a name in a file."""
    space = {"ask": is_unraisable}
    exec(compile(ASK.format(name=name), file, "exec"), space)  # noqa: S102  the text is above
    return space[name]()


@pytest.mark.parametrize(
    ("name", "file", "lost"),
    [
        ("run", __file__, False),
        ("__del__", __file__, True),
        ("_raw_object_cache_notify", engine.__file__, True),
        ("exec_module", "<frozen importlib._bootstrap_external>", True),
    ],
)
def test_places_where_an_exception_is_lost(name, file, lost):
    assert asked(name, file) == lost
    assert not is_unraisable(sys._getframe())
    assert hasattr(engine.ExecutionEngine, "_raw_object_cache_notify")


@pytest.mark.parametrize(("asked_for", "threads"), [(None, 1), ("2", min(2, len(os.sched_getaffinity(0))))])
def test_blas_has_one_thread_unless_a_number_is_asked_for(asked_for, threads):
    code = (
        "import os; from drill_twin.core.process import use_one_thread_of_blas; use_one_thread_of_blas(); "
        "import numpy; print(len(os.listdir('/proc/self/task')))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    environment |= {} if asked_for is None else {"OPENBLAS_NUM_THREADS": asked_for}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert int(done.stdout) == threads
