# SPDX-License-Identifier: Apache-2.0
"""Files that are none, at every reader; and tables as rigs and people leave them, at every use of a record."""

import os
import socket
import sys
from pathlib import Path

import pytest
from companion_parts import part
from variants import one_of

sys.path.insert(0, str(Path(__file__).parent))

from limited import harmless

import drill_twin as dt
from drill_twin.cli.analyze import analyze
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.report import build_report
from drill_twin.scene import load_scene
from drill_twin.scene.records import read_columns
from drill_twin.scene.set_points import read_table
from drill_twin.scene.well_plan.plan import read_survey
from drill_twin.scene.well_plan.tally import read_tally

DRILLBOTICS, KEYS, SIGNALS = (
    part(f"drill_twin_rig.gateway.{name}") for name in ("drillbotics", "opc_ua.keys", "signals")
)
MAPS = part("drill_twin_studies.maps.operating_map")

READERS = {
    "record.csv": read_columns, "record.las": read_columns, "record.xml": read_columns, "record.mat": read_columns,
    "survey.csv": lambda file: read_survey(file, "si"), "tally.csv": lambda file: read_tally(file, "si", 1000.0),
    "scene.yaml": load_scene, "signals.yaml": SIGNALS.read_signals,
    "users.yaml": KEYS.read_users, "map.json": MAPS.read_map,
    "run.npz": Checkpoint.load,
    "drilling_timeseries.csv": DRILLBOTICS and (lambda file: list(DRILLBOTICS.check_timeseries(file))),
}  # fmt: skip


def pipe(file):
    os.mkfifo(file, 0o600)


def listening(file):
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(file.name)
    file.chmod(0o600)


def endless(file):
    file.symlink_to("/dev/zero")


def itself(file):
    file.symlink_to(file.name)


def sparse(file):
    file.touch(0o600)
    os.truncate(file, 10**12)


def zeros(file):
    file.write_bytes(b"\0" * 3000)
    file.chmod(0o600)


def utf_16(file):
    file.write_text("time [s],RPM\n0,1\n1,1\n", "utf-16")
    file.chmod(0o600)


@pytest.mark.parametrize("make", [Path.mkdir, pipe, listening, endless, itself, sparse, zeros, utf_16])
@pytest.mark.parametrize("name", READERS)
def test_what_is_no_such_file_is_refused_at_once_in_one_sentence(tmp_path, monkeypatch, name, make):
    if not READERS[name]:
        READERS[name]()  # skips the test, which a child of it cannot
    monkeypatch.chdir(tmp_path)  # the name of a socket is short
    make(Path(name))
    told = harmless(READERS[name], Path(name))
    assert name.partition(".")[0] in told or (name, make) == ("record.csv", utf_16)  # which is read


HEAD = "time [s],WOB [kN],RPM [rpm],TQA [kN m]\n"
GOOD = "".join(f"{k / 10},10,{60 + k % 5},1\n" for k in range(50))


def rows(text):
    """Nine rows; `text` is made of k."""
    return "".join(f"{text(k)}\n" for k in range(9))


ODD = {
    "header only": HEAD, "header without an end": HEAD[:-1], "one row": f"{HEAD}0,1,60,1\n",
    "two rows": f"{HEAD}0,1,60,1\n1,1,60,1\n", "column of text": HEAD + rows(lambda k: f"{k},1,60,drilling"),
    "backwards": HEAD + rows(lambda k: f"{9 - k},1,60,1"), "once back": f"{HEAD}0,1,6,1\n1,1,6,1\n.5,1,6,1\n2,1,6,1\n",
    "one time": HEAD + "1,1,60,1\n" * 9, "all NaN": HEAD + "nan,nan,nan,nan\n" * 9,
    "no times": HEAD + "nan,1,60,1\n" * 9, "no values": HEAD + rows(lambda k: f"{k},,,"),
    "one value": HEAD + rows(lambda k: f"{k},,{60 if k == 4 else ''},"),
    "a row with a time": HEAD + ",1,60,1\n" * 4 + "3,1,60,1\n", "infinite": HEAD + rows(lambda k: f"{k},inf,inf,-inf"),
    "columns twice": "time [s],RPM [rpm],RPM [rpm]\n0,1,1\n1,1,1\n",
    "columns twice, in two cases": "time [s],RPM [rpm],rpm [rpm]\n0,1,1\n1,1,1\n", "blanks": " \n \n\n  \n",
    "blank cells": HEAD + " , , , \n" * 9, "commas": ",,,\n,,,\n", "no name": "time [s],,RPM [rpm]\n0,1,2\n1,1,2\n",
    "before 0": HEAD + rows(lambda k: f"{k - 5},1,60,1"), "decades": f"{HEAD}0,1,60,1\n2000000000,1,60,1\n",
    "picoseconds": HEAD + rows(lambda k: f"{k * 1e-12},1,60,1"), "late": HEAD + rows(lambda k: f"{1e9 + k},1,60,1"),
    "huge": HEAD + rows(lambda k: f"{k},1e300,1e300,1e300"), "zeros": HEAD + rows(lambda k: f"{k},0,0,0"),
    "negative": HEAD + rows(lambda k: f"{k},-1,-60,-1"), "gap": HEAD + rows(lambda k: f"{k + (k > 5) * 1e5},1,60,1"),
    "bit alone": "time [s],BRPM [rpm]\n" + rows(lambda k: f"{k},{60 + k % 3}"), "no units": "time,RPM\n0,1\n1,1\n",
    "decimal commas": (HEAD + GOOD).replace(",", ";").replace(".", ","), "tabs": (HEAD + GOOD).replace(",", "\t"),
    "quotes": '"time [s]","RPM [rpm]"\n' + rows(lambda k: f'"{k}","60"'), "open quote": HEAD + '0,"1,60,1\n' * 9,
    "dates": "DTIM,RPM [rpm]\n" + rows(lambda k: f"2024-05-01T12:00:{k:02d}Z,60"),
    "dates backwards": "DTIM,RPM [rpm]\n" + rows(lambda k: f"2024-05-01T12:00:{9 - k:02d}Z,60"),
    "a day that is none": "DTIM,RPM [rpm]\n" + rows(lambda k: f"2024-02-3{k}T12:00:00Z,60"),
    "ends of lines of 1984": (HEAD + GOOD).replace("\n", "\r"), "first row NaN": f"{HEAD}nan,nan,nan,nan\n{GOOD}",
    "zero byte": HEAD + "0,\0,1,1\n", "byte order mark": "\ufeff" + HEAD + GOOD,
}  # fmt: skip
"""Tables by what is odd about them."""
USES = (
    analyze,
    lambda file: build_report(file, file.parent / "report"),
    lambda file: read_table(file, longest_gap=1e9),  # of a run and of `rerun`
)
USES_OF_STUDIES = (
    lambda file: dt.read_record(file, ["top_drive_speed", "torque"]),  # of `fit`
    lambda file: dt.read_record(file, ["rotation", "weight_on_bit", "torque"]),  # of `estimate`
)


@pytest.mark.parametrize("name", one_of(3, ODD))
def test_an_odd_table_is_used_or_refused_in_one_sentence(tmp_path, name):
    file = tmp_path / "rig.csv"
    file.write_bytes(ODD[name].encode())
    for use in (*USES, *(USES_OF_STUDIES if MAPS else ())):
        said = harmless(use, file)
        assert not said or ": expected" in said, said
