# SPDX-License-Identifier: Apache-2.0
"""MATLAB file of variables."""

import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np

from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.json_files import read_json
from drill_twin.core.process import child_environment
from drill_twin.scene.records.columns import Columns
from drill_twin.scene.records.rows import LARGEST_FILE

MATLAB = ForeignFile("a MAT file", LARGEST_FILE, TableError, may_be_empty=False)
_MOST_BYTES = 200_000_000  # of all columns
_PATIENCE = 60  # s
_NOT_SUPPORTED = 3
_LOAD_MATLAB = """
import io, json, resource, sys
import numpy as np
from scipy.io import loadmat
with open("/proc/self/statm") as statm:
    size = int(statm.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + (1 << 30),) * 2)
try:
    content = loadmat(sys.stdin.buffer)
    columns = {}
    for name, value in content.items():
        array = np.asarray(value)
        is_column = array.size > 1 and array.size == max(array.shape) and array.dtype.kind in "fiu"
        if is_column and not name.startswith("__"):
            columns[name] = array.ravel().astype(np.float64)
    if sum(column.nbytes for column in columns.values()) > LARGEST:
        raise ValueError(f"columns of more than {LARGEST} bytes")
    out = io.BytesIO()
    np.savez(out, np.frombuffer(json.dumps(list(columns)).encode(), np.uint8), *columns.values())
except NotImplementedError:
    sys.exit(3)
except MemoryError:
    print("more than 1 GB in it", file=sys.stderr)
    sys.exit(2)
except BaseException as error:
    print(str(error)[:300], file=sys.stderr)
    sys.exit(2)
sys.stdout.buffer.write(out.getvalue())
""".replace("LARGEST", str(_MOST_BYTES))


def read_matlab(path: Path) -> Columns:
    """Read a MAT file by scipy in a separate process: a damaged file can crash scipy or request any amount of memory.

    Raises:
        TableError: The file is no MAT file, or is damaged.
    """
    try:
        with MATLAB.open(path) as stream:
            done = subprocess.run(
                [sys.executable, "-c", _LOAD_MATLAB],
                stdin=stream,
                capture_output=True,
                timeout=_PATIENCE,
                check=False,
                env=child_environment(),
            )
    except subprocess.TimeoutExpired:
        raise TableError(f"{path}: expected a MAT file, found one not read within {_PATIENCE} s") from None
    said = " ".join(done.stderr.decode("utf-8", "replace").split())
    if done.returncode == _NOT_SUPPORTED:
        raise TableError(f"{path}: expected a MAT file of version 5 to 7, found 7.3; save it with -v7")
    if done.returncode:
        raise TableError(f"{path}: expected a MAT file, found {said[-200:] or 'a damaged one'}")
    with np.load(BytesIO(done.stdout), allow_pickle=False) as archive:
        names = read_json(archive["arr_0"].tobytes())
        return Columns(path, {name: archive[f"arr_{place}"] for place, name in enumerate(names, 1)})
