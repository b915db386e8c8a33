# SPDX-License-Identifier: Apache-2.0
"""Environment of Python child processes, in which no module is imported from the working folder."""

import os
from collections.abc import Mapping
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[3]
_SITE = {"site-packages", "dist-packages"}


def child_environment(environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Environment for a child, by default from that of this process.

    `python -c` and `python -m` import from the working folder first, and so does a relative or an empty entry of
    PYTHONPATH: a `numpy.py` beside a recording would be run. Both are turned off, and the child imports this copy of
    the package.
    """
    given = dict(os.environ if environment is None else environment)
    entries = [entry for entry in given.get("PYTHONPATH", "").split(os.pathsep) if Path(entry).is_absolute()]
    own = [] if _SITE.intersection(_ROOT.parts) or str(_ROOT) in entries else [str(_ROOT)]
    return given | {"PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join([*own, *entries])}
