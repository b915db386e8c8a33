# SPDX-License-Identifier: Apache-2.0
"""Time and memory of the readers of records: `python -m drill_twin_evidence.benchmarks.readers [MEGABYTES]`.

Each use of a file runs in a process of its own; what the same takes for a file of ten rows is subtracted. Printed are
the processor time [s] and the largest resident memory over the size of the file.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.io import savemat

from drill_twin.core.process import child_environment

_FEW = 10
_DATE = np.datetime64("2026-05-14T13:57:00.000")
_WITSML = (
    '<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log><indexType>elapsed time</indexType>'
    "<logData><mnemonicList>TIME,WOB,RPM,TQA</mnemonicList><unitList>s,kN,rpm,kN.m</unitList>\n"
)
_LAS = (
    "~Version\nVERS. 2.0 :\nWRAP. NO :\n~Well\nNULL. -999.25 :\n~Curve\nTIME.S :\nWOB.KN :\nRPM.RPM :\nTQA.KN.M :\n"
    "~Ascii\n"
)
_END = "</logData></log></logs>\n"
_CSV = " [s],WOB [kN],RPM [rpm],TQA [kN m]\n"
TEXTS = {
    "CSV": (".csv", "time" + _CSV, "{time},{weight:.2f},{speed:.1f},{torque:.3f}\n", ""),
    "CSV, short cells": (".csv", "time" + _CSV, "{k},{k1},{k1},{k1}\n", ""),
    "CSV, dates and gaps": (".csv", "DTIM" + _CSV[4:], "{date}Z,,{speed:.1f},-999.25\n", ""),
    "LAS": (".las", _LAS, "{time}   {weight:.2f} {speed:.1f} {torque:.3f}\n", ""),
    "LAS, notes": (".las", _LAS[:-7] + "NOTE. :\n~A\n", "{time} -999.25 {speed:.1f} {torque:.3f} drilling\n", ""),
    "WITSML": (".xml", _WITSML, "<data>{time},{weight:.2f},{speed:.1f},{torque:.3f}</data>\n", _END),
}  # fmt: skip
"""Ending, begin, row and end by kind."""
USES = {
    "columns": "from drill_twin.scene.records import read_columns; read_columns(path)",
    "to play": "from drill_twin.scene.set_points import read_table; "
    "read_table(path, wanted=['rotation'], longest_gap=9e9)",
    "report": "from drill_twin.report import read_recording; read_recording(path)",
}
"""Programs by use of a record."""


class Cost(NamedTuple):
    """Of one process."""

    seconds: float
    """Processor time [s]."""
    memory: float
    """Largest resident memory [bytes]."""


def main(megabytes: float = 10.0) -> None:
    """Write each kind, read it in each way, and print the costs."""
    print("file                  size [MB]  " + "  ".join(f"{use}: time [s]  memory [sizes]" for use in USES))
    with tempfile.TemporaryDirectory() as name:
        for kind in (*TEXTS, "MAT"):
            few, many = (_write(Path(name), kind, size) for size in (0.0, megabytes * 1e6))
            size, told = many.stat().st_size, []
            for program in list(USES.values())[: 1 if kind == "MAT" else None]:  # it has no unit of time
                base, full = cost(program, few), cost(program, many)
                told.append(f"{full.seconds - base.seconds:18.2f}  {(full.memory - base.memory) / size:14.1f}")
            print(f"{kind:20}  {size / 1e6:9.1f}  {'  '.join(told)}", flush=True)


def cost(program: str, path: Path) -> Cost:
    """Cost of a program that reads a file, its own children included."""
    code = (
        f"import pathlib, resource; path = pathlib.Path({str(path)!r}); {program}\n"
        "used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]\n"
        "print(sum(u.ru_utime + u.ru_stime for u in used), max(u.ru_maxrss for u in used) * 1024)"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=child_environment())
    return Cost(*map(float, done.stdout.split()[-2:]))


def _write(folder: Path, kind: str, size: float) -> Path:
    """Write a file of a kind of about so many bytes, of ten rows at least."""
    if kind == "MAT":
        path, count = folder / f"{size:.0f}.mat", max(int(size / 32.0), _FEW)
        time = 0.1 * np.arange(count)
        savemat(path, {"time": time, "RPM": 120.0 + time % 9.0, "wob_kN": time % 7.0, "tqa_kNm": time % 3.0})
        return path
    ending, begin, row, end = TEXTS[kind]
    path = folder / f"{kind.replace(' ', '_')}_{size:.0f}{ending}"
    with path.open("w", encoding="utf-8") as stream:
        stream.write(begin)
        for k, numbers in enumerate(_rows()):
            if k >= _FEW and stream.tell() >= size:
                break
            stream.write(row.format(**numbers))
        stream.write(end)
    return path


def _rows() -> Iterator[dict[str, object]]:
    """Numbers as a rig logs them ten times a second, without end."""
    k = 0
    while True:
        yield {
            "k": k, "k1": k % 10, "time": f"{0.1 * k:.1f}", "date": _DATE + np.timedelta64(100 * k, "ms"),
            "weight": 100.0 + k % 97 / 7.0, "speed": 120.0 + k % 89 / 9.0, "torque": 5.0 + k % 83 / 11.0,
        }  # fmt: skip
        k += 1


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
